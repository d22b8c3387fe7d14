// Notes on the sessions and conditions of compared people, for people.
#pragma once

#include <string>
#include <vector>

#include "identify/groups.hpp"

namespace decid::tools {

/// Returns notes on sessions or conditions that are not compared and differ between the groups: the differences of
/// groups contain theirs. has_study: --within can compare them without another option.
std::vector<std::string> notes_on_mixed(const GroupReport& groups, bool has_study);

/// Returns true if all compared recordings are of one person.
bool has_one_person(const GroupReport& groups);

/// Returns a note if most of the compared sessions have one person alone, as each person's dates have; else nothing, as
/// for the sessions of one person.
std::vector<std::string> notes_on_lone_sessions(const GroupReport& groups);

/// Returns a note if the compared sessions are dates such as 3/4/2024, whose day and month may be swapped.
std::vector<std::string> notes_on_dates(const GroupReport& groups);

}  // namespace decid::tools
