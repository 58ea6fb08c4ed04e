// SPDX-License-Identifier: Zlib
// In a file of its own, since the game is C++11 and our headers are C++17.
#include "Volumetric.h"

#include <BulletHapticForce/btBulletHapticForceCommon.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

struct Volumetric
{
	explicit Volumetric(btDiscreteDynamicsWorld& game) : world(game), trees(world.registration().registry(), settings()) {}
	static btISTTreeSettings settings()
	{
		btISTTreeSettings chosen;
		chosen.cacheFolder = "trees";
		return chosen;
	}

	btISTWorld world;
	btISTTreeSource trees;
	std::vector<btISTPendingAttachment> meshes;
	bool begun = false;
};

namespace
{
std::string mode()
{
	const char* chosen = std::getenv("BPP_VOLUMETRIC");
	return chosen ? chosen : "";
}

/// 0 where the environment has no such number.
double number(const char* name)
{
	const char* chosen = std::getenv(name);
	return chosen ? std::atof(chosen) : 0;
}

void tell(const std::optional<ist::Error>& refused)
{
	if (refused) std::fprintf(stderr, "%s\n", refused->message.c_str());
}

void chooseCost(btISTWorld& world)
{
	if (const double leafPairs = number("BPP_PAIR_BUDGET")) tell(world.setPairBudget(int64_t(leafPairs)));
	if (const double error = number("BPP_FORCE_ERROR")) tell(world.setForceError(error));
	if (const double error = number("BPP_KEPT_ERROR")) tell(world.setContactCache({true, error}));
}

void setStiffness(Volumetric& volumetric)
{
	const double stiffness = number("BPP_STIFFNESS");
	const btCollisionObjectArray& objects = volumetric.world.bullet().getCollisionObjectArray();
	for (int i = 0; stiffness != 0 && i < objects.size(); ++i)
		if (objects[i]->getCollisionShape()->getShapeType() == GIMPACT_SHAPE_PROXYTYPE)
			tell(volumetric.world.materials().set(objects[i], {stiffness}));
}
}  // namespace

std::shared_ptr<Volumetric> makeVolumetric(btDiscreteDynamicsWorld& world)
{
	return mode() == "off" ? nullptr : std::make_shared<Volumetric>(world);
}

void updateVolumetric(Volumetric* volumetric)
{
	if (!volumetric || volumetric->begun || mode() == "idle") return;
	volumetric->begun = true;
	chooseCost(volumetric->world);
	volumetric->meshes = volumetric->trees.attachGImpact(volumetric->world.bullet());
	const int attached = volumetric->trees.finish();
	setStiffness(*volumetric);
	std::fprintf(stderr, "%d of %zu GImpact shapes have trees\n", attached, volumetric->meshes.size());
	for (const btISTPendingAttachment& mesh : volumetric->meshes)
		if (!mesh.error().empty()) std::fprintf(stderr, "%s\n", mesh.error().c_str());
}
