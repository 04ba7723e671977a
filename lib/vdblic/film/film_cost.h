#pragma once

#include <string>

namespace vdblic {

struct FilmPlan;
struct StreakCost;

/// \file
/// Estimates of what a film takes. A film of both costs what each costs.

/// Add what a dense texture costs, by its voxels. Fitted to pictures of the wake with 0.2 and 0.9 million pixels, of
/// 0.1 to 7 million voxels, with and without lines.
/// @param pixels of a picture  @param withLines whether streaks follow: then a pixel has two rays
void addDenseCost(FilmPlan& plan, double pixels, bool withLines);

/// Add what streaks cost. Fitted to default films of the wake, a ring and a tornado, and to pictures of the wake with
/// 0.2 to 3.7 million pixels. @param cost of a frame  @param pixels of a picture
void addStreakCost(FilmPlan& plan, const StreakCost& cost, double pixels);

/// The estimates, for people: "339.7 MiB of memory and 129 s of processor time".
[[nodiscard]] std::string costText(const FilmPlan& plan);

} // namespace vdblic
