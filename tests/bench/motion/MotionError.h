// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/bench/motion/MotionRun.h"

#include <optional>
#include <vector>

namespace bench
{
/// Difference of two poses of a body, as a share of its size: the distance of the centres over `size`, plus half of the angle of the
/// rotation between them [rad]. No point of a body that is `size` long about its centre is displaced by a larger share.
double poseError(const MotionState& a, const MotionState& b, double size);

/// Pose error at each checkpoint, of the body where it is largest. Infinite where a pose is not finite.
std::vector<double> motionErrors(const MotionRun& run, const MotionRun& reference);
/// Errors of a run at each checkpoint against the closed form; empty where the scene has none.
std::vector<double> closedFormErrors(const MotionRun& run, const MotionScene& scene);
/// Largest of the first `count` values.
double largest(const std::vector<double>& errors, size_t count);

/// What runs tend to as the step goes to zero, from a run and one in steps of twice the length (Richardson): the motion of steps of first
/// order is off by a multiple of the step. Costs are those of `run`.
MotionRun extrapolated(const MotionRun& run, const MotionRun& atTwiceTheStep);

/// How far two runs are apart that begin a `perturbation` apart.
struct MotionGrowth
{
	double factor = 1;       ///< largest error over `perturbation`
	double judged = 1;       ///< the same before that, and at least 1
	size_t checkpoints = 0;  ///< checkpoints before the error is a hundredfold of it; all, if it never is
};
MotionGrowth growthOf(const MotionRun& run, const MotionRun& perturbed, double perturbation);

/// How the error of a run is spread over the intervals between checkpoints.
enum class ErrorCharge
{
	Pose,  ///< an interval is charged by how much the difference of the poses, as a vector, changes in it
	/// An interval is charged by what its own forces add: the change of the poses beyond what the difference of velocities at its beginning
	/// makes, and the change of that difference times the time that is left.
	Velocity
};
/// Error that a run adds in each of the first `count` - 1 intervals, of the body where it is largest.
std::vector<double> addedErrors(const MotionRun& run, const MotionRun& reference, size_t count, ErrorCharge charge);

/// A run, as a choice for each interval.
struct MotionChoice
{
	std::vector<double> costs, errors;  ///< in each interval
	double rate = 1;                    ///< steps a second
};
/// Least cost of a choice that is the same in all intervals, and of one choice in each. In both the errors of all intervals add up to at
/// most the tolerance. The second is what knowledge of all runs allows, by a Lagrange multiplier: a lower bound on the cost of any control
/// of the step among these. Nothing where no choice of the first kind is within the tolerance.
struct MotionHindsight
{
	double fixedCost = 0, bestCost = 0;
	size_t fixed = 0;  ///< index of the first choice
};
std::optional<MotionHindsight> bestInHindsight(const std::vector<MotionChoice>& choices, double tolerance);

/// A control of the step that does not know the future, at its best: it learns the error of an interval once it has stepped through it, for
/// nothing and without an error of the estimate. It takes the coarsest choice whose error, as one of first order, should keep the sum of
/// errors within the share of the tolerance that the time gone by allows. If the error is larger, the interval is stepped again, finer, and
/// both costs count.
struct MotionControl
{
	double cost = 0, error = 0;
};
/// `choices` from the coarsest to the finest.
MotionControl controlled(const std::vector<MotionChoice>& choices, double tolerance);
}  // namespace bench
