#include "triangles.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "link_motion.hpp"
#include "se3.hpp"

namespace onemap::mapping {

namespace {

struct Triangle {
  std::array<std::size_t, 3> pairs{};  // x-y, y-z, x-z
  bool closes = false;
};

// Chi square of the way from x to z over y, back by the direct link.
double surprise(const ChainFrames& frames, const LinkMotion& xy, const LinkMotion& yz, const LinkMotion& xz) {
  const Vector6d error = motion_error(xz.T_a_x * (xy.T_x_y * yz.T_x_y * xz.T_x_y.inverse()) * xz.T_a_x.inverse());
  const Matrix6d in_y = yz.covariance + frames.between(xy.link->b, yz.link->a);
  const Matrix6d in_x = xy.covariance + xz.covariance + frames.between(xy.link->a, xz.link->a) +
                        xy.y_to_x * in_y * xy.y_to_x.transpose() +
                        xz.y_to_x * frames.between(yz.link->b, xz.link->b) * xz.y_to_x.transpose();
  return chi_square(error, xz.to_a * in_x * xz.to_a.transpose());
}

// Links that agree, but not from where they should all be, may not join; they may speak.
bool is_hearsay(const ChainPair& pair) {
  return pair.verdict.reason == JoinReason::one_place || pair.verdict.reason == JoinReason::unlinked_beside;
}
bool is_witness(const ChainPair& pair) { return !pair.own() && (pair.joined() || is_hearsay(pair)); }

std::optional<std::size_t> find_pair(const std::vector<ChainPair>& pairs, std::size_t chain_a, std::size_t chain_b) {
  const auto at = std::lower_bound(pairs.begin(), pairs.end(), std::pair{chain_a, chain_b},
                                   [](const ChainPair& pair, const auto& chains) {
                                     return std::pair{pair.chain_a, pair.chain_b} < chains;
                                   });
  if (at == pairs.end() || at->chain_a != chain_a || at->chain_b != chain_b) return std::nullopt;
  return static_cast<std::size_t>(at - pairs.begin());
}

std::vector<Triangle> triangles_of(const GraphIndex& index, const ChainFrames& frames, double chi2,
                                   const std::vector<ChainPair>& pairs) {
  std::vector<std::optional<LinkMotion>> motions(pairs.size());
  std::vector<std::vector<std::size_t>> from(index.chains.size());  // by their first chain
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!is_witness(pairs[i])) continue;
    motions[i] = motion_of(frames, index.links[pairs[i].best].edge, false);
    from[pairs[i].chain_a].push_back(i);
  }
  std::vector<Triangle> out;
  for (const auto& pairs_of_x : from)
    for (std::size_t xy : pairs_of_x)
      for (std::size_t yz : from[pairs[xy].chain_b])
        if (const auto xz = find_pair(pairs, pairs[xy].chain_a, pairs[yz].chain_b); xz && motions[*xz])
          out.push_back({{xy, yz, *xz}, surprise(frames, *motions[xy], *motions[yz], *motions[*xz]) <= chi2});
  return out;
}

// In links.
struct Voice {
  double with = 1, against = 0;  // more than none, so that shares can be compared
  double hearsay_with = 0, hearsay_against = 0;
  void hear(bool closes, bool hearsay, double links) {
    // Places that look alike are many: of rings with hearsay only the loudest counts.
    if (hearsay)
      (closes ? hearsay_with : hearsay_against) = std::max(links, closes ? hearsay_with : hearsay_against);
    else
      (closes ? with : against) += links;
  }
  double all_with() const { return with + hearsay_with; }
  double all_against() const { return against + hearsay_against; }
  bool doubtful(double share) const { return all_against() > share * all_with(); }
};

std::vector<Voice> voices_of(const std::vector<ChainPair>& pairs, const std::vector<Triangle>& triangles) {
  std::vector<Voice> out(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i)  // who is not joined has nothing to lose
    if (pairs[i].joined() && !pairs[i].own())
      out[i] = {static_cast<double>(pairs[i].verdict.agree), static_cast<double>(pairs[i].verdict.second)};
  for (const Triangle& triangle : triangles) {
    const auto& [xy, yz, xz] = triangle.pairs;
    const auto hear = [&](std::size_t pair, std::size_t other, std::size_t third) {
      if (!pairs[pair].joined()) return;
      const double links = std::min(pairs[other].verdict.agree, pairs[third].verdict.agree);
      out[pair].hear(triangle.closes, is_hearsay(pairs[other]) || is_hearsay(pairs[third]), links);
    };
    hear(xy, yz, xz);
    hear(yz, xy, xz);
    hear(xz, xy, yz);
  }
  return out;
}

// The worst, and what else is doubtful in its rings: it must not stay because the worst went.
std::vector<std::size_t> doubted(const std::vector<Voice>& voices, const std::vector<Triangle>& triangles,
                                 double share) {
  const auto worst = std::max_element(voices.begin(), voices.end(), [](const Voice& x, const Voice& y) {
    return x.all_against() * y.all_with() < y.all_against() * x.all_with();
  });
  if (worst == voices.end() || !worst->doubtful(share)) return {};
  std::vector<std::size_t> out{static_cast<std::size_t>(worst - voices.begin())};
  for (const Triangle& triangle : triangles)
    if (!triangle.closes && std::ranges::count(triangle.pairs, out[0]) > 0)
      for (std::size_t pair : triangle.pairs)
        if (std::ranges::count(out, pair) == 0 && voices[pair].doubtful(share)) out.push_back(pair);
  return out;
}

}  // namespace

void doubt_triangles(const GraphIndex& index, const ChainFrames& frames, const JoinConfig& config,
                     std::vector<ChainPair>& pairs) {
  std::vector<Triangle> triangles = triangles_of(index, frames, config.ring_chi2, pairs);
  while (true) {
    const std::vector<Voice> voices = voices_of(pairs, triangles);
    const std::vector<std::size_t> out = doubted(voices, triangles, config.second_group_share);
    if (out.empty()) return;
    for (std::size_t pair : out) {
      pairs[pair].verdict.reason = JoinReason::contradicts_others;
      pairs[pair].verdict.number = voices[pair].all_against();
    }
    std::erase_if(triangles, [&](const Triangle& triangle) {
      return std::ranges::any_of(triangle.pairs, [&](std::size_t pair) { return !is_witness(pairs[pair]); });
    });
  }
}

}  // namespace onemap::mapping
