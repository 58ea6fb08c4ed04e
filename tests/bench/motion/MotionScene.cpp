// SPDX-License-Identifier: Zlib
#include "tests/bench/motion/MotionScene.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include <utility>

using namespace ist;

namespace bench
{
std::optional<Error> MotionScene::add(const char* name, const Mesh& mesh, long long spheres, const browser::DemoOptions& options)
{
	browser::SolidPtr made;
	if (auto error = browser::makeSolid(made, name, mesh, spheres, options)) return error;
	m_solids.push_back(std::move(made));
	return std::nullopt;
}

void MotionScene::addLevels()
{
	for (browser::SolidPtr& solid : m_solids)
	{
		auto tree = std::make_shared<InnerSphereTree>(*solid->tree);
		ist::addLevels(*tree);
		auto levelled = std::make_shared<browser::DemoSolid>(*solid);
		levelled->tree = std::move(tree);
		solid = std::move(levelled);
	}
}

std::vector<MotionEntry> motionScenes()
{
	std::vector<MotionEntry> all;
	for (const auto& part : {flightScenes(), frictionScenes(), impactScenes(), assemblyScenes()})
		all.insert(all.end(), part.begin(), part.end());
	return all;
}

browser::BodySetup bodySetup(const char* name, double mass, double friction, bool isGiven, double stiffness, double dissipation)
{
	browser::BodySetup setup;
	setup.name = name;
	setup.mass = mass;
	setup.fixed = mass == 0;
	setup.friction = friction;
	setup.stiffness = isGiven ? stiffness : 0;
	setup.dissipation = isGiven ? dissipation : -1;
	return setup;
}

void setVelocity(btRigidBody& body, const Vec3& velocity, const Vec3& angular)
{
	body.setLinearVelocity(toBullet(velocity));
	body.setAngularVelocity(toBullet(angular));
	body.setInterpolationLinearVelocity(body.getLinearVelocity());
	body.setInterpolationAngularVelocity(body.getAngularVelocity());
}
}  // namespace bench
