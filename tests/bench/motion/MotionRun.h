// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/bench/motion/MotionScene.h"

#include <string>
#include <vector>

namespace bench
{
/// What a run of a scene may choose.
struct MotionSettings
{
	enum class Contact
	{
		Given,    ///< ours, with the materials of the scene
		Default,  ///< ours, with nothing set
		Stock     ///< Bullet's own
	};
	Contact contact = Contact::Given;
	int rate = 60;            ///< steps a second, a multiple of kCheckpointRate
	double forceError = 0;    ///< accepted force error (btISTWorld::setForceError); 0: the finest answer always
	double perturbation = 0;  ///< each body begins displaced and turned by about this share of its size; see perturb()

	/// Puts right what Bullet's integrator errs in free flight: after each step a body that nothing touches is moved back by g h^2 / 2.
	bool isFlightExact = false;
	/// Number of spheres of each tree; 0: that of the scene. The caller prepares the scene so.
	int spheres = 0;

	/// A name for files, such as "given-60".
	std::string name() const;
};

/// State of a judged body at a checkpoint, World.
struct MotionState
{
	ist::Vec3 position;
	ist::Quaternion rotation;
	ist::Vec3 velocity, angular;
};

/// What a run has cost since its beginning.
struct MotionCost
{
	double steps = 0, queries = 0;  ///< steps, and queries of contact
	double pairs = 0;               ///< pairs of leaves, and faces, that the queries found
	double seconds = 0;             ///< processor time [s]

	/// Queries and steps together: a count that depends on no machine.
	double count() const { return queries + steps; }
};
MotionCost operator-(const MotionCost& a, const MotionCost& b);

struct MotionCheckpoint
{
	double time = 0;
	MotionCost cost;
	std::vector<MotionState> bodies;
};

/// Motion of the judged bodies of a scene, at every 1 / kCheckpointRate.
struct MotionRun
{
	std::vector<double> sizes;  ///< longest side of each body [m]
	std::vector<MotionCheckpoint> checkpoints;
};

/// Runs a prepared scene for `seconds`. In stock Bullet the costs of queries are zero.
ist::Result<MotionRun> runMotion(MotionScene& scene, double seconds, const MotionSettings& settings);

/// Text of a run, and a run from its text. Broken text gives an error.
std::string textOf(const MotionRun& run);
ist::Result<MotionRun> runOfText(const std::string& text);
}  // namespace bench
