// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Tuning/TuneSettings.h"

#include <optional>

namespace ist
{
/// How two bodies meet.
struct WorldSetup
{
	std::optional<double> stiffness;  ///< k of the pair [Pa/m]
	std::optional<double> mass;       ///< of the lighter body; of two that both move freely 1 / (1/m_A + 1/m_B) [kg]
	double speed = 0;                 ///< with which they meet [m/s]
	double step = 1.0 / 60;           ///< of the game [s]
	double distance = 0;              ///< from the origin of the world [m]
};

/// What a world must be like so that neither its step nor its numbers err by more than is accepted. The contact is that of the body at rest
/// under its weight.
struct TimeStepAdvice
{
	double restDepth = 0;        ///< overlap volume over area, m g / (k A) [m]
	double frequency = 0;        ///< sqrt(k A / m) [rad/s]
	double explicitStep = 0;     ///< the longest that explicit forces bear [s]
	double restitutionStep = 0;  ///< the longest that keeps 1 - error of the speed of an impact; infinite without speed [s]
	double thicknessStep = 0;    ///< the longest in which nothing passes unseen; infinite without speed [s]
	double stepNeeded = 0;       ///< the least of the last two and the game's [s]
	int substeps = 1;            ///< of the game's step
	bool explicitWill = false;   ///< explicit forces bear `stepNeeded`
	bool inDouble = false;       ///< places in float would move the resting force by more than the error
};

/// Why no step can be chosen for it: it lacks a stiffness or a mass.
std::optional<Error> problemOf(const WorldSetup& setup);

/// Errors: `problemOf`, contacts without area.
Result<TimeStepAdvice> worldNeeds(
	const WorldSetup& setup, const InnerSphereTree& A, const InnerSphereTree& B, const std::vector<TuneContact>& contacts, double error);
}  // namespace ist
