#pragma once
#include <array>
#include <cassert>
#include <cstddef>
#include <string_view>

// Handshake patterns as tables (The Noise Protocol Framework, revision 34, section 7).
namespace onemap::comms::noise {

enum class Token { e, s, ee, es, se, ss, psk };

// The tokens of one message.
struct Message {
  std::array<Token, 6> tokens{};
  std::size_t size = 0;
  constexpr void add(Token token) {
    assert(size < tokens.size());
    tokens[size++] = token;
  }
  constexpr const Token* begin() const { return tokens.data(); }
  constexpr const Token* end() const { return tokens.data() + size; }
};

struct Pattern {
  bool initiator_known = false, responder_known = false;  // whose static key the other one has before
  bool with_psk = false;
  std::array<Message, 5> messages{};  // by turns, the initiator first
  std::size_t size = 0;
};

constexpr Token token_of(std::string_view word) {
  if (word == "e") return Token::e;
  if (word == "s") return Token::s;
  if (word == "ee") return Token::ee;
  if (word == "es") return Token::es;
  if (word == "se") return Token::se;
  if (word == "ss") return Token::ss;
  assert(word == "psk");
  return Token::psk;
}

// From words with messages parted by '/': "e / e ee s es / s se psk".
constexpr Pattern pattern(std::string_view words, bool initiator_known = false, bool responder_known = false) {
  Pattern out;
  out.initiator_known = initiator_known;
  out.responder_known = responder_known;
  out.size = 1;
  while (!words.empty()) {
    const std::size_t end = words.find(' ') == std::string_view::npos ? words.size() : words.find(' ');
    const std::string_view word = words.substr(0, end);
    words.remove_prefix(end == words.size() ? end : end + 1);
    if (word == "/") {
      ++out.size;
      continue;
    }
    out.messages[out.size - 1].add(token_of(word));
    out.with_psk = out.with_psk || word == "psk";
  }
  return out;
}

// What onemap speaks: both sides send their static keys, sealed, and prove that they know the team's key.
inline constexpr std::string_view kProtocolName = "Noise_XXpsk3_25519_ChaChaPoly_BLAKE2b";
inline constexpr Pattern kXXpsk3 = pattern("e / e ee s es / s se psk");

}  // namespace onemap::comms::noise
