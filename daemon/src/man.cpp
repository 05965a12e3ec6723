#include "daemon/man.hpp"

#include <fmt/format.h>

#include "daemon/cameras.hpp"
#include "daemon/config_key.hpp"

namespace onemap::daemon {

namespace {

// As text: nothing in it is a request or an escape, and a '-' is the one that can be copied.
std::string roff(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool at_start = out.empty() || out.back() == '\n';
    if (at_start && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out;
}

std::string title(const char* name, const char* section) {
  return fmt::format(".TH {} {} \"\" \"onemap {}\"\n.nh\n", name, section, ONEMAP_VERSION);
}

std::string heading(std::string_view name) { return fmt::format(".SH {}\n", name); }

// A word in bold, and under it what it is.
std::string item(std::string_view word, std::string_view rest, std::string_view text) {
  return fmt::format(".TP\n\\fB{}\\fR{}{}\n{}\n", roff(word), rest.empty() ? "" : " ", roff(rest), roff(text));
}

std::string of_key(const ConfigKey& key) {
  const char* reload =
      key.reload == Reload::live ? "A running daemon takes a change over (SIGHUP)." : "A change waits for a restart.";
  return item(key.name, "= " + toml_text(key.get({})), key.text + ".\n") +
         fmt::format("Accepted: {}.\n{}\n", roff(key.values), roff(reload));
}

constexpr const char* kConfigNames = R"(onemap.toml \- configuration of onemapd
)";

constexpr const char* kConfigText = R"(.B onemapd
reads
.I /etc/onemap/onemap.toml
and then, in the order of their names, the files
.IR /etc/onemap/onemap.toml.d/*.toml ,
which go over it.
.B \-\-config
.I FILE
names another file, and then
.I FILE.d/*.toml
are its drop\-ins.
The robots of one machine that run as
.BI onemapd@ NAME .service
have
.I /etc/onemap/NAME.toml
each.
The command line goes over all files.
.PP
The files are TOML.
Every key has a default, which is shown here: a robot that has a supported camera needs no line and no file, alone or with the
key of its team
.RB ( "onemapctl team" ),
which it then looks for in the multicast group 239.77.1.1:4600 of its network. For that the machine needs a route there: a default
one, or one to 224.0.0.0/4.
A key or section that does not exist, and a value that is not accepted, are errors that say the file, the line and what was
probably meant;
.B onemapd \-\-check\-config
says all of them at once,
.B onemapd \-\-dump\-config
the values that hold and where each is from, and
.B onemapd \-\-help\-config
this page as a file to start from.
.PP
After
.B systemctl reload onemapd
(SIGHUP) the files are read again.
What a running daemon can take over it does; of every other change the log says that it waits for a restart.
A configuration with an error changes nothing.
)";

constexpr const char* kConfigEnd = R"(.SH EXAMPLE
A robot of a team in which some find each other on their network, and one is elsewhere:
.PP
.nf
[robot]
id = "kitchen"

[network]
listen = "0.0.0.0:4600"
group = "239.77.1.1:4600"
peers = ["10.8.0.2:4600"]
.fi
.SH SEE ALSO
.BR onemapd (8),
.BR onemapctl (1),
.BR systemctl (1)
)";

constexpr const char* kDaemonText = R"(.B onemapd
tracks an RGB\-D camera, builds a 3D map in fixed memory, and exchanges what it learns with the robots that it reaches over
UDP.
Every robot of a team ends with the same map, byte for byte, and with everybody's trajectory.
What is not said on the command line is in the configuration, see
.BR onemap.toml (5),
or has its default.
.PP
It is one process a robot and stays in the foreground.
A recording without
.B \-\-once
is played to its end, and the daemon then keeps serving what it knows until it is stopped.
)";

constexpr const char* kDaemonEnd = R"(.SH SIGNALS
.TP
.B SIGTERM, SIGINT
End the work: what there is is written.
.TP
.B SIGHUP
Read the configuration again.
.SH AS A SERVICE
.B systemctl enable \-\-now onemapd
starts it with the machine, as the user
.BR onemap .
It is ready when the camera and the sockets are up; a camera that is not there yet, or a control socket that cannot be made, is
tried for again every two seconds, and a wrong configuration (exit status 2) is not.
.B systemctl status onemapd
shows what the robot is doing.
A daemon that ended badly, and one of whose mapping threads (capture, pipeline, publisher, team, radio) does not get on any more,
is started again, and finds its place in what its neighbours hold.
What a thread writes that only keeps or draws is watched by nobody: a disk may take its time.
Several robots of one machine are
.BI onemapd@ NAME .service\fR,
with the file
.I /etc/onemap/NAME.toml
and the id NAME.
.PP
The unit allows cameras, its own state and runtime folders, 1.5 GB of memory and the addresses of private networks.
Larger budgets want a larger
.BR MemoryMax ,
robots elsewhere want their
.BR IPAddressAllow :
.BR "systemctl edit onemapd" .
.SH ENVIRONMENT
.TP
.B STATE_DIRECTORY
Where it writes when
.B robot.out
is not given; without it
.IR $XDG_STATE_HOME/onemap ,
.IR ~/.local/state/onemap .
.TP
.B NOTIFY_SOCKET, WATCHDOG_USEC, WATCHDOG_PID
The service manager's, see
.BR sd_notify (3).
.SH FILES
.TP
.I /etc/onemap/onemap.toml, /etc/onemap/onemap.toml.d/*.toml
The configuration.
.TP
.I /var/lib/onemap
The service's state folder:
.I life
(the number of this robot's lives),
.I log
(the records of the whole team, which outlive this robot),
.I status.json
(what it is doing),
.I identity
and
.I known_robots
(this robot's key, and those of the robots that it has met),
.I settled\-map
and the
.I map\-DIGEST.omap
that it names (the last map that all robots held, which
.B onemap\-view
draws when the robot is off),
.I map.pgm
and
.I map.yaml
(its floor plan, if
.BR map.refresh_plan ).
At its end the service, which is stopped within two seconds
.RB ( \-\-quick\-stop ),
writes the map once more,
.IR trajectory.txt ,
.IR global/*.txt ,
.I graph.g2o
and
.IR report.json ;
without that option pictures, models and the last floor plan are written, too.
.PP
What is spoilt there is set aside under another name, which the log says, and the daemon goes on without it.
The exception are
.I identity
and
.IR known_robots ,
of a robot that is not alone: without them whoever takes a robot's name would be believed, so the start ends (exit status 2, which
the service manager does not try again) until somebody brings the file back, mends it or removes it.
.SH SEE ALSO
.BR onemap.toml (5),
.BR onemapctl (1),
.BR systemctl (1)
)";

}  // namespace

std::string man_of_config() {
  std::string text = title("ONEMAP.TOML", "5") + heading("NAME") + kConfigNames + heading("DESCRIPTION") + kConfigText;
  text += heading("KEYS");
  for (const ConfigSection& section : config_sections()) {
    text += fmt::format(".SS [{}]\n{}.\n", section.name, roff(section.text));
    for (const ConfigKey& key : config_keys())
      if (key.section == section.name) text += of_key(key);
  }
  return text + kConfigEnd;
}

std::string man_of_daemon(std::span<const ManOption> options, std::span<const ManExit> exits) {
  std::string text = title("ONEMAPD", "8") + heading("NAME") + "onemapd \\- one map, on every robot\n" +
                     heading("SYNOPSIS") + ".B onemapd\n[\\fIOPTIONS\\fR]\n" + heading("DESCRIPTION") + kDaemonText;
  text += heading("OPTIONS");
  for (const ManOption& option : options) text += item(option.name, option.type, option.text);
  text += heading("CAMERAS") + item("auto", "", "the first usable camera of this machine; see --cameras");
  for (const hal::Backend& backend : camera_backends()) text += item(backend.name, "", backend.description);
  text += heading("\"EXIT STATUS\"");
  for (const ManExit& exit : exits) text += item(std::to_string(exit.status), "", exit.text);
  return text + kDaemonEnd;
}

}  // namespace onemap::daemon
