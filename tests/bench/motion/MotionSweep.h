// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/bench/motion/MotionError.h"
#include "tests/bench/motion/MotionRecords.h"

#include <array>
#include <string>
#include <vector>

namespace bench
{
inline constexpr double kPerturbation = 1e-6;
inline constexpr std::array kTolerances = {1e-1, 1e-2, 1e-3, 1e-4};
inline constexpr std::array kForceErrors = {0.05, 0.2};  ///< accepted force errors that are measured
inline constexpr std::array kFewSpheres = {100, 400};    ///< numbers of spheres that are measured
inline constexpr int kSphereRate = 240;                  ///< at this rate [Hz]

/// One run, judged until the motion can no longer be foreseen.
struct MotionRow
{
	MotionSettings settings;
	double error = 0;         ///< largest pose error against the reference
	double closedError = -1;  ///< against the closed form; negative: there is none
	double singleError = -1;  ///< `error` in single precision; negative: not measured
	/// With an accepted force error, or few spheres: against the run at the same rate without; negative otherwise.
	double queryError = -1;
	MotionCost cost;  ///< for one second of the scene
};

/// What holds for one choice of contact.
struct MotionTruth
{
	double convergence = 0;   ///< pose error of the reference of half the rate against the reference
	double closedError = -1;  ///< pose error of the reference against the closed form; negative: there is none
	MotionGrowth growth;      ///< of a perturbation
	double until = 0;         ///< time until which runs are judged [s]
};

/// Fixed steps against steps chosen in hindsight.
struct MotionGain
{
	double tolerance = 0;  ///< share of the body for a second
	double allowed = 0;    ///< the error that is allowed: tolerance times the time judged and the growth of a perturbation in it
	double byCount = 0, bySeconds = 0;  ///< cost of the best fixed step over cost in hindsight, by queries and steps, and by time; 0: none
	double byVelocity = 0;              ///< by queries and steps, with ErrorCharge::Velocity
	/// Cost of the best fixed step over that of a control of the step (`controlled`), by queries and steps, with each charge; 0: it misses
	/// the tolerance.
	double byControl = 0, byControlOfVelocity = 0;
	int rate = 0;  ///< best fixed rate, by queries and steps
};

struct MotionFindings
{
	MotionEntry entry;
	size_t bodies = 0;
	double size = 0;        ///< of the first body [m]
	int referenceRate = 0;  ///< rate of the finest run, from which and half of it the reference is extrapolated
	MotionTruth truths[2];  ///< with materials given, and with nothing set
	std::vector<MotionRow> rows;
	std::vector<MotionGain> gains;

	/// The row with these settings, and the scene's own number of spheres; null where it was not measured.
	const MotionRow* row(MotionSettings::Contact contact, int rate, double forceError = 0, bool isFlightExact = false) const;
	/// The row with so many spheres; null where it was not measured.
	const MotionRow* rowOfSpheres(int spheres) const;
	/// The cheapest row of a contact, by queries and steps, whose error is at most `tolerance`; null: none.
	const MotionRow* cheapest(MotionSettings::Contact contact, double tolerance) const;
};

/// Rates of steps that are measured in a scene.
std::vector<int> ratesOf(const MotionEntry& entry);
/// All runs of a scene in this precision: in single precision only those with materials given. Returns why one could not be made.
std::optional<ist::Error> recordRuns(MotionRecords& records, const MotionEntry& entry);
/// What the recorded runs say. An error where the runs in double precision are missing.
ist::Result<MotionFindings> judgeRuns(MotionRecords& records, const MotionEntry& entry);
/// The scene has a reference of 3840 Hz then, for a look within a minute.
MotionEntry quick(MotionEntry entry);
}  // namespace bench
