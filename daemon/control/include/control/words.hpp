#pragma once
#include <string>

#include "control/protocol.hpp"

// What a daemon answers, as people read it: a few lines or a table.
namespace onemap::control {

std::string status_words(const Json& answer);
std::string peers_words(const Json& answer);
std::string consensus_words(const Json& answer);
std::string map_words(const Json& answer);
std::string pose_words(const Json& answer);  // one line
std::string cameras_words(const Json& answer);
std::string findings_words(const Json& findings);  // of DOCTOR
std::string why_words(const Json& answer);         // of WHY
std::string event_words(const Json& object);       // one line: anything that comes unasked
std::string fields_words(const Json& answer);      // whatever there is, a line each

// Columns as wide as their widest cell, two spaces between them; the first row is the head.
std::string table(const std::vector<std::vector<std::string>>& rows);

}  // namespace onemap::control
