#include "control/ctl.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <functional>
#include <optional>
#include <set>

#include "control/calibrate.hpp"
#include "control/client.hpp"
#include "control/doctor.hpp"
#include "control/doctor_alone.hpp"
#include "control/found_cameras.hpp"
#include "control/socket_place.hpp"
#include "control/team_commands.hpp"
#include "control/words.hpp"
#include "control/wrapped.hpp"
#include "hal/base/text.hpp"

namespace onemap::control {

namespace {

constexpr const char* kFooter =
    "Examples:\n"
    "  onemapctl status                     what the robot is doing\n"
    "  onemapctl pose --follow --json       every pose as JSON, one a line\n"
    "  onemapctl watch EVENT PEERS          what happens in the team\n"
    "  onemapctl --socket /run/onemap/r2/control.sock map\n"
    "  onemapctl doctor                     what is wrong, and what to do\n"
    "  onemapctl team init                  a key for a new team; no daemon is needed\n"
    "  onemapctl calibrate recordings/1 --from nominal.txt --out mine.txt\n"
    "\nWithout --socket: $ONEMAP_SOCKET, else the one socket that there is in $RUNTIME_DIRECTORY, /run/onemap and\n"
    "$XDG_RUNTIME_DIR/onemap. A daemon with neither has it in its OUT folder, and its log says where.\n"
    "\nExit status:\n"
    "  0  done\n"
    "  1  the daemon refused or could not, and the message says why; doctor: something is wrong\n"
    "  2  bad command line; nobody was asked\n"
    "  3  no daemon answers; doctor and cameras then say what can be seen without one\n";

struct Options {
  std::string socket;
  bool json = false, follow = false;
  double timeout_s = 10;
  std::string path, a, b;
  std::vector<std::string> classes, maps, views, kinds, words;
  TeamOptions team;
};

struct Ctl {
  const Options options;
  ControlClient client;

  Duration patience() const {
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(options.timeout_s));
  }
};

int complain(CtlExit exit, const std::string& what) {
  std::fputs(("onemapctl: " + printable(what) + "\n").c_str(), stderr);
  return static_cast<int>(exit);
}

// False: nobody reads any more.
bool show(const std::string& text) { return std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0; }

int fail(const Error& error) {
  return complain(error.place.empty() ? CtlExit::refused : CtlExit::no_daemon, error.text());
}

using Words = std::function<std::string(const Json&)>;

int ask(Ctl& ctl, const Json& request, const Words& words) {
  const auto answer = ctl.client.ask(request, ctl.patience());
  if (!answer) return fail(answer.error());
  const bool shown = show(ctl.options.json ? line_of(*answer) : words(*answer));
  return shown ? 0 : complain(CtlExit::refused, "standard output cannot be written to");
}

// Until the daemon ends, or nobody reads.
int follow(Ctl& ctl, const std::vector<std::string>& classes) {
  Json request{{"class", "WATCH"}, {"enable", true}};
  if (!classes.empty()) request["classes"] = classes;
  if (auto begun = ctl.client.ask(request, ctl.patience()); !begun) return fail(begun.error());
  for (;;) {
    const auto object = ctl.client.receive(std::chrono::hours(24 * 365));
    if (!object) return fail(object.error());
    if (!show(ctl.options.json ? line_of(*object) : event_words(*object))) return 0;
  }
}

std::string metrics_words(const Json& answer) { return answer.value("text", ""); }

// A request with what was given of these.
Json request_of(const char* name, std::initializer_list<std::pair<const char*, std::string>> keys) {
  Json request{{"class", name}};
  for (const auto& [key, value] : keys)
    if (!value.empty()) request[key] = value;
  return request;
}

int record(Ctl& ctl, bool enable) {
  Json request = request_of("RECORD", {{"path", ctl.options.path}});
  request["enable"] = enable;
  return ask(ctl, request, fields_words);
}

void show_findings(const Options& options, const Json& findings) {
  show(options.json ? line_of({{"class", "DOCTOR"}, {"findings", findings}}) : findings_words(findings));
}

int doctor(Ctl& ctl) {
  const auto answer = ctl.client.ask({{"class", "DOCTOR"}}, ctl.patience());
  if (!answer) return fail(answer.error());
  Json findings = answer->value("findings", Json::array());
  for (Json& finding : own_findings(ctl.options.socket)) findings.push_back(std::move(finding));
  bool good = true;
  for (const Json& finding : findings) good = good && finding.value("ok", false);
  show_findings(ctl.options, findings);
  return static_cast<int>(good ? CtlExit::done : CtlExit::refused);
}

// No daemon answers, for this reason.
int doctor_alone(const Options& options, const Error& why) {
  Json findings = findings_without_daemon(why, this_machine());
  findings.push_back(look_at_clock());
  show_findings(options, findings);
  return complain(CtlExit::no_daemon, why.text());
}

// The answer, which has the robot's own camera when a daemon gave one, with those that this machine has.
int show_cameras(const Options& options, Json answer) {
  const auto found = found_cameras(this_machine());
  if (found) answer.update(*found);
  if (!found) answer["not_found_because"] = found.error().text();
  const bool shown = show(options.json ? line_of(answer) : cameras_words(answer));
  return shown ? 0 : complain(CtlExit::refused, "standard output cannot be written to");
}

int cameras(Ctl& ctl) {
  auto answer = ctl.client.ask({{"class", "CAMERAS"}}, ctl.patience());
  return answer ? show_cameras(ctl.options, std::move(*answer)) : fail(answer.error());
}

int cameras_alone(const Options& options, const Error& why) {
  show_cameras(options, {{"class", "CAMERAS"}});
  return complain(CtlExit::no_daemon, why.text());
}

using Run = std::function<int(Ctl&)>;
using RunAlone = std::function<int(const Options&)>;  // without a daemon

int say(const Options& options, const Result<TeamSaid>& said) {
  if (!said) return complain(CtlExit::refused, said.error().text());
  return show(options.json ? line_of(said->json) : said->words)
             ? 0
             : complain(CtlExit::refused, "standard output cannot be written to");
}

// Not an argument by default: those can be seen by everybody on the machine.
int join_team(const Options& options) {
  std::string line = options.team.key;
  if (line.empty()) {
    std::array<char, 256> text{};
    if (std::fgets(text.data(), text.size(), stdin) == nullptr)
      return complain(CtlExit::usage, "team join reads the key from standard input, and there is none");
    line = text.data();
  }
  return say(options, team_join(options.team, line));
}

// The command line, and what was chosen on it.
struct CommandLine {
  CLI::App app{"onemapctl - asks onemapd what it knows, and tells it what to do", "onemapctl"};
  Options options;
  Run run;
  RunAlone run_alone;                                                       // if this is set
  std::function<int(const Options&, const Error& why)> run_without_daemon;  // if it is set and no daemon answers

  CLI::App* command(const char* name, const char* text, Run what) {
    CLI::App* sub = app.add_subcommand(name, text);
    sub->callback([this, what = std::move(what)] { run = what; });
    return sub;
  }
  CommandLine();
  void declare_reading();
  void declare_changing();
  void declare_team();
  void declare_calibrate();
};

CommandLine::CommandLine() {
  app.set_version_flag("--version", "onemapctl " ONEMAP_VERSION);
  app.add_option("--socket", options.socket, "control socket of the daemon")->type_name("PATH");
  app.add_flag("--json", options.json, "JSON instead of words, one object a line");
  app.add_option("--timeout", options.timeout_s, "seconds to wait for an answer (default 10)")
      ->type_name("S")
      ->check(CLI::Range(0.1, 86400.0));
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(kFooter);
  declare_reading();
  declare_changing();
  declare_team();
  declare_calibrate();
}

void CommandLine::declare_reading() {
  const auto plain = [this](const char* name, const char* text, const char* asked, const Words& words) {
    return command(name, text, [asked, words](Ctl& ctl) { return ask(ctl, {{"class", asked}}, words); });
  };
  plain("status", "what the robot is doing", "STATUS", status_words);
  plain("peers", "whom it hears, and who holds which map", "PEERS", peers_words);
  plain("consensus", "what the team agrees on: clocks, brightness, its size", "CONSENSUS", consensus_words);
  plain("map", "the map that it holds, and what became of pairs of robots", "MAP", map_words);
  command("pose", "where the camera is: time, state, frame, x y z qx qy qz qw", [](Ctl& ctl) {
    return ctl.options.follow ? follow(ctl, {"POSE"}) : ask(ctl, {{"class", "POSE"}}, pose_words);
  })->add_flag("--follow", options.follow, "every frame's, until it ends");
  command("watch", "what happens, as it happens", [](Ctl& ctl) { return follow(ctl, ctl.options.classes); })
      ->add_option("classes", options.classes, "of POSE, EVENT, PEERS, STATUS; none: all")
      ->type_name("CLASS");
  plain("metrics", "counters and gauges as Prometheus text", "METRICS", metrics_words);
  app.add_subcommand("cameras", "what the robot sees with, and what else is there; also when no daemon answers")
      ->callback([this] {
        run = cameras;
        run_without_daemon = cameras_alone;
      });
  app.add_subcommand("doctor", "what is wrong, and what to do; also when no daemon answers")->callback([this] {
    run = doctor;
    run_without_daemon = doctor_alone;
  });
}

void CommandLine::declare_changing() {
  auto* snapshot = command("snapshot", "draw the maps as they are now", [](Ctl& ctl) {
    const Options& o = ctl.options;
    Json request{{"class", "SNAPSHOT"}};
    for (const auto& [key, words] : {std::pair{"maps", &o.maps}, {"views", &o.views}, {"kinds", &o.kinds}})
      if (!words->empty()) request[key] = *words;
    return ask(ctl, request, fields_words);
  });
  snapshot->add_option("--map", options.maps, "global or local; several times for several")->type_name("MAP");
  snapshot->add_option("--view", options.views, "fit, top, follow, plan or front")->type_name("VIEW");
  snapshot->add_option("--kind", options.kinds, "png, glb or plan")->type_name("KIND");
  command("save", "write the map below the daemon's OUT; NAME.log: the team's records, for load", [](Ctl& ctl) {
    return ask(ctl, request_of("SAVE", {{"path", ctl.options.path}}), fields_words);
  })->add_option("path", options.path, "its name below OUT; else saved.omap");
  command("load", "go on in the map that was saved as NAME.log; of a .omap: whether it is whole",
          [](Ctl& ctl) {
            return ask(ctl, request_of("LOAD", {{"path", ctl.options.path}}), fields_words);
          })
      ->add_option("path", options.path, "its name below OUT")
      ->required();
  auto* recording = app.add_subcommand("record", "keep the camera's frames, as replay: reads them");
  recording->require_subcommand(1);
  recording->fallthrough();
  recording->add_subcommand("start", "from now on")
      ->callback([this] { run = [](Ctl& ctl) { return record(ctl, true); }; })
      ->add_option("path", options.path, "folder below OUT; without it recordings/NUMBER");
  recording->add_subcommand("stop", "no longer")->callback([this] {
    run = [](Ctl& ctl) { return record(ctl, false); };
  });
  const auto pair = [this](const char* name, const char* text, const char* asked, const Words& words) {
    auto* sub = command(name, text, [asked, words](Ctl& ctl) {
      return ask(ctl, request_of(asked, {{"a", ctl.options.a}, {"b", ctl.options.b}}), words);
    });
    sub->add_option("a", options.a, "a robot")->required();
    sub->add_option("b", options.b, "another")->required();
  };
  pair("why", "why two robots are in one map, or are not", "WHY", why_words);
  pair("unmerge", "take what joins two robots back", "UNMERGE", fields_words);
  pair("merge", "let what joins two robots count again", "MERGE", fields_words);
}

void CommandLine::declare_team() {
  auto* team = app.add_subcommand("team", "the key that all robots of a team have");
  team->require_subcommand(1);
  team->fallthrough();
  const auto one = [&](const char* name, const char* text, RunAlone what) {
    auto* sub = team->add_subcommand(name, text);
    sub->callback([this, what = std::move(what)] { run_alone = what; });
    sub->add_option("--file", options.team.file, "where it is; /etc/onemap/team.key")->type_name("FILE");
    return sub;
  };
  one("init", "make a key for a new team", [](const Options& o) {
    return say(o, team_init(o.team));
  })->add_flag("--force", options.team.force, "in place of the key that there is");
  one("show", "which key there is, by its fingerprint", [](const Options& o) {
    return say(o, team_show(o.team));
  })->add_flag("--secret", options.team.secret, "the key itself, for another robot's team join");
  auto* join = one("join", "take the team's key from a line of standard input", join_team);
  join->add_option("key", options.team.key, "the line, instead; others on this machine can see it");
  join->add_flag("--force", options.team.force, "in place of the key that there is");
}

// All that follows is onemap-calibrate's, --help too.
void CommandLine::declare_calibrate() {
  CLI::App* sub = app.add_subcommand("calibrate", "where the depth lens is, from a recording; see calibrate --help");
  sub->fallthrough(false)->prefix_command()->set_help_flag();
  sub->callback([this, sub] {
    options.words = sub->remaining();
    run_alone = [](const Options& o) {
      std::vector<std::string> words = o.words;
      if (o.json) words.insert(words.begin(), "--json");
      return complain(CtlExit::refused, become_calibrate(words).text());
    };
  });
}

// Where to ask, or why that cannot be told.
Result<std::string> find_socket(const Options& options) {
  if (!options.socket.empty()) return options.socket;
  const auto likely = likely_sockets(environment());
  if (likely.size() == 1) return likely[0];
  if (likely.empty())
    return Error{
        "no control socket",
        "there is none in $RUNTIME_DIRECTORY, /run/onemap or $XDG_RUNTIME_DIR/onemap; is onemapd running? Its log "
        "says where its socket is: say --socket PATH"};
  return Error{"several daemons", fmt::format("say --socket with one of {}", fmt::join(likely, ", "))};
}

int connect_and_run(const CommandLine& line) {
  Options options = line.options;
  const auto no_daemon = [&](const Error& why) {
    return line.run_without_daemon ? line.run_without_daemon(options, why) : complain(CtlExit::no_daemon, why.text());
  };
  auto socket = find_socket(options);
  if (!socket) return no_daemon(socket.error());
  options.socket = *socket;
  const auto patience = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(options.timeout_s));
  auto client = ControlClient::connect(options.socket, patience);
  if (!client) return no_daemon(client.error());
  Ctl ctl{options, std::move(*client)};
  return line.run(ctl);
}

}  // namespace

std::vector<std::string> ctl_commands() {
  const CommandLine line;
  std::vector<std::string> names;
  for (const CLI::App* sub : line.app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  return names;
}

namespace {
void add_options(const CLI::App& app, std::set<std::string>& names) {
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.insert(name);
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) add_options(*sub, names);
}
}  // namespace

std::vector<std::string> ctl_options() {
  std::set<std::string> names;
  add_options(CommandLine().app, names);
  return {names.begin(), names.end()};
}

std::string ctl_help() { return CommandLine().app.help(); }

int run_ctl(int argc, char** argv) {
  try {
    CommandLine line;
    try {
      line.app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
      const auto chosen = line.app.get_subcommands();
      return show(wrapped(chosen.empty() ? line.app.help() : chosen[0]->help("onemapctl")))
                 ? 0
                 : complain(CtlExit::refused, "standard output cannot be written to");
    } catch (const CLI::CallForVersion& version) {
      return show(std::string(version.what()) + "\n") ? 0 : 1;
    } catch (const CLI::ParseError& error) {
      complain(CtlExit::usage, error.what());
      std::fputs("onemapctl --help says what there is\n", stderr);
      return static_cast<int>(CtlExit::usage);
    }
    return line.run_alone ? line.run_alone(line.options) : connect_and_run(line);
  } catch (const std::exception& error) {
    return complain(CtlExit::refused, error.what());
  }
}

}  // namespace onemap::control
