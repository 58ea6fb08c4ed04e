// SPDX-License-Identifier: Zlib
// In a file of its own, since the game is C++11 and our headers are C++17.
#include "Volumetric.h"

#include <BulletHapticForce/btBulletHapticForceCommon.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <cstdlib>
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
	std::vector<btISTPendingAttachment> hulls;
	uint64_t touched = 0;  ///< pairs of two trees that overlapped, summed over all steps
};

namespace
{
void count(btDynamicsWorld* world, btScalar)
{
	auto& volumetric = *static_cast<Volumetric*>(world->getWorldUserInfo());
	for (const btISTContact* contact : volumetric.world.contacts().contacts())
		volumetric.touched += contact->treeB && contact->total.volume > 0;
}

/// The hulls among a shape and its children. Boxes, cylinders and capsules meet trees as they are.
void attachHulls(const btCollisionShape& shape, Volumetric& volumetric)
{
	if (shape.isCompound())
	{
		const auto& compound = static_cast<const btCompoundShape&>(shape);
		for (int i = 0; i < compound.getNumChildShapes(); ++i) attachHulls(*compound.getChildShape(i), volumetric);
	}
	else if (shape.getShapeType() == CONVEX_HULL_SHAPE_PROXYTYPE || shape.getShapeType() == MULTI_SPHERE_SHAPE_PROXYTYPE)
		volumetric.hulls.push_back(volumetric.trees.attach(&shape));
}
}  // namespace

std::shared_ptr<Volumetric> makeVolumetric(btDiscreteDynamicsWorld& world)
{
	auto made = std::make_shared<Volumetric>(world);
	if (!made->world.solverRefusal().empty()) std::fprintf(stderr, "%s\n", made->world.solverRefusal().c_str());
	return made;
}

void attachVolumetric(Volumetric& volumetric)
{
	const char* mode = std::getenv("VDRIFT_VOLUMETRIC");
	if (mode && std::string(mode) == "idle") return;
	btDiscreteDynamicsWorld& world = volumetric.world.bullet();
	for (int i = 0; i < world.getNonStaticRigidBodies().size(); ++i)
		attachHulls(*world.getNonStaticRigidBodies()[i]->getCollisionShape(), volumetric);
	const int attached = volumetric.trees.finish();
	std::fprintf(stderr, "%d of %zu hulls have trees\n", attached, volumetric.hulls.size());
	for (const btISTPendingAttachment& hull : volumetric.hulls)
		if (!hull.error().empty()) std::fprintf(stderr, "%s\n", hull.error().c_str());
	world.setInternalTickCallback(count, &volumetric);
}

void detachVolumetric(Volumetric& volumetric)
{
	if (!volumetric.hulls.empty())
		std::fprintf(
			stderr, "volumetric contact of two hulls in %llu pairs and steps\n", static_cast<unsigned long long>(volumetric.touched));
	volumetric.hulls.clear();
	volumetric.touched = 0;
}
