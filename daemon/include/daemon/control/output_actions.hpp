#pragma once
#include "daemon/control/control_actions.hpp"
#include "daemon/recorder.hpp"
#include "daemon/snapshots.hpp"

namespace onemap::daemon {

// What clients may ask of the outputs; both outlive the actions.
//
// SNAPSHOT: `map` (global or local), `view` (fit, top, follow, plan, front) and `format` (png, glb or plan) choose what
// is made, each as configured when it is not given; the answer has `folder` and `files`. With `path` the first of them
// is copied there.
ControlActions::Action snapshot_action(Snapshots& snapshots, const Config& config);

// RECORD: `enable` (true), `path`: the folder, below OUT when it is relative; without it OUT/recordings/NUMBER. The
// answer has `recording`, `folder`, `frames`, `bytes`, `dropped`, and `ended` where it ended by itself.
ControlActions::Action record_action(Recorder& recorder, const Config& config);

}  // namespace onemap::daemon
