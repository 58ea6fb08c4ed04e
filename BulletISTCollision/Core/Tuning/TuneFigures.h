// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Tuning/PairTuning.h"

#include <cmath>
#include <optional>

namespace ist
{
/// Calls say(name, value) for each figure, in order, with the names that the command and the Python module use. A value is a number, a
/// bool, a text, or an optional number, which is empty if there is no bound.
template <class Say> void eachFigure(const TuneSetting& s, Say&& say)
{
	say("spheres", s.spheres);
	if (s.level < 0) say("level", "by pose");
	else say("level", s.level);
	say("error", s.error);
	say("time_us", s.microseconds);
	say("pairs", s.pairs);
	say("patches", s.patches);
}

template <class Say> void eachFigure(const TimeStepAdvice& needs, Say&& say)
{
	const auto bounded = [](double step) { return std::isfinite(step) ? std::optional<double>(step) : std::nullopt; };
	say("precision", needs.inDouble ? "double" : "float");
	say("substeps", needs.substeps);
	say("rate_hz", 1 / needs.stepNeeded);
	say("explicit", needs.explicitWill);
	say("rest_depth_m", needs.restDepth);
	say("frequency_rad_s", needs.frequency);
	say("explicit_step_s", needs.explicitStep);
	say("restitution_step_s", bounded(needs.restitutionStep));
	say("thickness_step_s", bounded(needs.thicknessStep));
}

/// All figures except the alternatives.
template <class Say> void eachFigure(const PairTuning& tuning, Say&& say)
{
	eachFigure(tuning.best, say);
	say("spheres_a", tuning.spheresA);
	say("spheres_b", tuning.spheresB);
	say("kept", tuning.kept);
	if (tuning.world) eachFigure(*tuning.world, say);
}
}  // namespace ist
