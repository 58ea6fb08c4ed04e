// SPDX-License-Identifier: Zlib
// Measures the cost of the first step of a game's world that becomes volumetric: time of the caller's thread [ms] and resident memory.
// The stages are the construction of btISTWorld, the first step without a contact, and the first step in which two rings overlap.
// Usage: bench_first_step [ROUNDS=3]
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <unistd.h>

namespace
{
/// Resident memory of this process [MB].
double residentMegabytes()
{
	long size = 0, resident = 0;
	if (FILE* file = std::fopen("/proc/self/statm", "r"))
	{
		if (std::fscanf(file, "%ld %ld", &size, &resident) != 2) resident = 0;
		std::fclose(file);
	}
	return double(resident) * double(sysconf(_SC_PAGESIZE)) * 1e-6;
}

/// Runs one stage and prints its time and memory.
template <class Stage> void measure(const char* name, const Stage& stage)
{
	const double before = residentMegabytes();
	const auto start = std::chrono::steady_clock::now();
	stage();
	const double milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
	std::printf("  %-34s %8.2f ms  %+7.2f MB\n", name, milliseconds, residentMegabytes() - before);
}

/// A game with two rings. The upper one starts above the lower one and is lowered onto it.
void play(const std::shared_ptr<const ist::InnerSphereTree>& tree, btTriangleMesh& triangles)
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
	btGImpactMeshShape ring(&triangles);
	ring.updateBound();
	btRigidBody lower(0, nullptr, &ring), upper(1, nullptr, &ring, btVector3(1, 1, 1));
	upper.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 0, 2)));
	world.addRigidBody(&lower);
	world.addRigidBody(&upper);
	world.stepSimulation(btScalar(1) / 60, 0);
	std::optional<btISTWorld> ist;
	btISTAttachment attachment;
	measure("btISTWorld is made", [&] { ist.emplace(world); });
	measure("a shape gets its tree", [&] { attachment = ist->attach(&ring, tree).value(); });
	measure("first step, nothing touches", [&] { world.stepSimulation(btScalar(1) / 60, 0); });
	upper.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(0.35))));
	measure("first step with contact", [&] { world.stepSimulation(btScalar(1) / 60, 0); });
	for (const btISTContact* contact : ist->contacts().contacts())
		std::printf(
			"  pairs of leaves %ld, patches %d, volume %.6f m^3\n", long(contact->total.pairs), contact->patchCount, contact->total.volume);
	measure("the next step", [&] { world.stepSimulation(btScalar(1) / 60, 0); });
	attachment.detach();
	ist.reset();
	world.removeRigidBody(&lower);
	world.removeRigidBody(&upper);
}
}  // namespace

int main(int argc, char** argv)
{
	const ist::Mesh mesh = ist::makeTorusMesh(0.5, 0.2, 32, 16);
	btTriangleMesh triangles;
	const auto vertex = [&](uint32_t i) {
		const ist::Vec3& p = mesh.vertices[i];
		return btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z));
	};
	for (const auto& triangle : mesh.triangles) triangles.addTriangle(vertex(triangle[0]), vertex(triangle[1]), vertex(triangle[2]));
	ist::BuildOptions options;
	options.maxSpheres = 3000;
	options.threads = 1;
	const auto tree = std::make_shared<const ist::InnerSphereTree>(ist::buildTree(mesh, options).value());
	const int rounds = argc > 1 ? std::atoi(argv[1]) : 3;
	for (int i = 0; i < rounds; ++i)
	{
		std::printf("world %d\n", i + 1);
		play(tree, triangles);
	}
}
