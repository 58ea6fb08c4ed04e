// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Tuning/TuneSettings.h"

#include <optional>

namespace ist
{
/// Conditions under which two bodies meet.
struct WorldSetup
{
	std::optional<double> stiffness;  ///< k of the pair [Pa/m]
	std::optional<double> mass;       ///< mass of the lighter body; if both move freely, 1 / (1/m_A + 1/m_B) [kg]
	double speed = 0;                 ///< speed with which they meet [m/s]
	double step = 1.0 / 60;           ///< time step of the game [s]
	double distance = 0;              ///< distance from the origin of the world [m]
};

/// Requirements on a world, so that neither its time step nor its precision causes a larger error than accepted. The contact considered
/// is that of the body at rest under its weight.
struct TimeStepAdvice
{
	double restDepth = 0;        ///< overlap volume over area, m g / (k A) [m]
	double frequency = 0;        ///< sqrt(k A / m) [rad/s]
	double explicitStep = 0;     ///< longest step that is stable with explicit forces [s]
	double restitutionStep = 0;  ///< longest step that keeps 1 - error of the speed of an impact; infinite without speed [s]
	double thicknessStep = 0;    ///< longest step in which no body passes through undetected; infinite without speed [s]
	double stepNeeded = 0;       ///< smallest of the last two and the game's step [s]
	int substeps = 1;            ///< number of substeps of the game's step
	bool explicitWill = false;   ///< true if explicit forces are stable with `stepNeeded`
	bool inDouble = false;       ///< true if positions in float would change the resting force by more than the error
};

/// The reason why no step can be chosen: the setup lacks a stiffness or a mass.
std::optional<Error> problemOf(const WorldSetup& setup);

/// Computes the requirements. Errors: `problemOf`, contacts without area.
Result<TimeStepAdvice> timeStepAdvice(
	const WorldSetup& setup, const InnerSphereTree& A, const InnerSphereTree& B, const std::vector<TuneContact>& contacts, double error);
}  // namespace ist
