// SPDX-License-Identifier: Zlib
// In a file of its own, since the game is C++11 and our headers are C++17.
#include "Volumetric.h"

#include <BulletHapticForce/btBulletHapticForceCommon.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <cstdlib>
#include <string>

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
}  // namespace

std::shared_ptr<Volumetric> makeVolumetric(btDiscreteDynamicsWorld& world)
{
	return mode() == "off" ? nullptr : std::make_shared<Volumetric>(world);
}

void updateVolumetric(Volumetric* volumetric)
{
	if (!volumetric || volumetric->begun || mode() == "idle") return;
	volumetric->begun = true;
	volumetric->meshes = volumetric->trees.attachGImpact(volumetric->world.bullet());
	const int attached = volumetric->trees.finish();
	std::fprintf(stderr, "%d of %zu GImpact shapes have trees\n", attached, volumetric->meshes.size());
	for (const btISTPendingAttachment& mesh : volumetric->meshes)
		if (!mesh.error().empty()) std::fprintf(stderr, "%s\n", mesh.error().c_str());
}
