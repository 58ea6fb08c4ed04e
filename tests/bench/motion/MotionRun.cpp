// SPDX-License-Identifier: Zlib
#include "tests/bench/motion/MotionRun.h"

#include "BulletISTCollision/Core/Base/ThreadTime.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include <cmath>
#include <cstdio>
#include <locale>
#include <random>
#include <sstream>

using namespace ist;

namespace bench
{
namespace
{
std::vector<const browser::DemoWorld::Body*> judgedBodies(const browser::DemoWorld& world)
{
	std::vector<const browser::DemoWorld::Body*> judged;
	for (const browser::DemoWorld::Body& body : world.bodies())
		if (!body.body->isStaticOrKinematicObject()) judged.push_back(&body);
	return judged;
}

/// Displaces and turns the bodies at random. Where joints hold bodies, their velocities change instead, so that no joint is opened.
void perturb(browser::DemoWorld& world, double share)
{
	std::mt19937 random(1);
	std::normal_distribution<double> gauss;
	for (const browser::DemoWorld::Body* each : judgedBodies(world))
	{
		btRigidBody& body = *each->body;
		const Vec3 shift = share * bounds(each->visibleMesh()).longestSide() * normalized({gauss(random), gauss(random), gauss(random)});
		const Vec3 turn = 2 * share * normalized({gauss(random), gauss(random), gauss(random)});
		if (world.constraintCount() > 0)
		{
			setVelocity(body, toVec3(body.getLinearVelocity()) + shift, toVec3(body.getAngularVelocity()) + turn);
			continue;
		}
		Pose X = toPose(body.getWorldTransform());
		X.translation += shift;
		X.rotation = rotationMatrix(quaternionFromRotationVector(turn)) * X.rotation;
		body.setWorldTransform(toTransform(X));
		body.setInterpolationWorldTransform(body.getWorldTransform());
	}
}

bool isTouched(browser::DemoWorld& world, const btRigidBody& body)
{
	for (const btISTContact* contact : world.volumetric()->contacts().contacts())
		if (contact->patchCount > 0 && (contact->bodyA == &body || contact->bodyB == &body)) return true;
	return false;
}

void correctFlight(browser::DemoWorld& world, double h)
{
	for (const browser::DemoWorld::Body* each : judgedBodies(world))
	{
		btRigidBody& body = *each->body;
		if (isTouched(world, body)) continue;
		body.translate(btScalar(-0.5 * h * h) * body.getGravity());
		body.setInterpolationWorldTransform(body.getWorldTransform());
	}
}

MotionCheckpoint checkpoint(browser::DemoWorld& world, double time, MotionCost cost)
{
	MotionCheckpoint at{time, cost, {}};
	if (btISTWorld* ours = world.volumetric())
	{
		at.cost.queries = double(ours->contacts().cost().asked);
		at.cost.pairs = double(ours->contacts().cost().leafPairs);
	}
	for (const browser::DemoWorld::Body* body : judgedBodies(world))
	{
		const Pose X = body->X_WP();
		at.bodies.push_back(
			{X.translation, quaternion(X.rotation), toVec3(body->body->getLinearVelocity()), toVec3(body->body->getAngularVelocity())});
	}
	return at;
}

std::optional<Error> prepareWorld(browser::DemoWorld& world, MotionScene& scene, const MotionSettings& settings)
{
	scene.build(world, settings.contact == MotionSettings::Contact::Given);
	if (world.error()) return world.error();
	world.keepAwake(true);
	if (settings.perturbation > 0) perturb(world, settings.perturbation);
	btISTWorld* ours = world.volumetric();
	if (!ours) return std::nullopt;
	ours->setLog([](const char*) {});
	ours->contacts().measureQueryTime(false);
	return settings.forceError > 0 ? ours->setForceError(settings.forceError) : std::nullopt;
}
}  // namespace

MotionCost operator-(const MotionCost& a, const MotionCost& b)
{
	return {a.steps - b.steps, a.queries - b.queries, a.pairs - b.pairs, a.seconds - b.seconds};
}

std::string MotionSettings::name() const
{
	static const char* const contacts[] = {"given", "default", "stock"};
	char text[80];
	std::snprintf(text, sizeof text, "%s-%d", contacts[int(contact)], rate);
	std::string name = text;
	if (forceError > 0) name += "-error" + std::to_string(std::lround(1000 * forceError));
	if (perturbation > 0) name += "-perturbed";
	if (isFlightExact) name += "-flight";
	if (spheres > 0) name += "-" + std::to_string(spheres) + "spheres";
	return name;
}

Result<MotionRun> runMotion(MotionScene& scene, double seconds, const MotionSettings& settings)
{
	browser::DemoWorld world(
		settings.contact == MotionSettings::Contact::Stock ? scenes::Response::Stock : scenes::Response::Volumetric, scene.gravity());
	if (const auto error = prepareWorld(world, scene, settings)) return *error;
	MotionRun run;
	for (const browser::DemoWorld::Body* body : judgedBodies(world)) run.sizes.push_back(bounds(body->visibleMesh()).longestSide());
	const double h = 1.0 / settings.rate;
	const int each = settings.rate / kCheckpointRate, checkpoints = int(std::lround(seconds * kCheckpointRate));
	MotionCost cost;
	run.checkpoints.push_back(checkpoint(world, 0, cost));
	for (int i = 1; i <= checkpoints; ++i)
	{
		const double begin = threadMicroseconds();
		for (int k = 0; k < each; ++k)
		{
			scene.beforeStep(h * ((i - 1) * each + k));
			world.step(h);
			if (settings.isFlightExact) correctFlight(world, h);
		}
		cost.seconds += 1e-6 * (threadMicroseconds() - begin);
		cost.steps += each;
		run.checkpoints.push_back(checkpoint(world, double(i) / kCheckpointRate, cost));
	}
	return run;
}

std::string textOf(const MotionRun& run)
{
	std::string text;
	const auto put = [&](double value, char end = ' ') {
		char number[40];
		std::snprintf(number, sizeof number, "%.17g%c", value, end);
		text += number;
	};
	put(double(run.sizes.size()));
	put(double(run.checkpoints.size()), '\n');
	for (const double size : run.sizes) put(size);
	text.back() = '\n';
	for (const MotionCheckpoint& at : run.checkpoints)
	{
		for (const double value : {at.time, at.cost.steps, at.cost.queries, at.cost.pairs, at.cost.seconds}) put(value);
		for (const MotionState& b : at.bodies)
			for (const double value : {b.position.x, b.position.y, b.position.z, b.rotation.x, b.rotation.y, b.rotation.z, b.rotation.w,
					 b.velocity.x, b.velocity.y, b.velocity.z, b.angular.x, b.angular.y, b.angular.z})
				put(value);
		text.back() = '\n';
	}
	return text;
}

Result<MotionRun> runOfText(const std::string& text)
{
	std::istringstream in(text);
	in.imbue(std::locale::classic());
	// Through text, so that "nan" and "inf" are read, too.
	const auto get = [&](double& value) {
		std::string word;
		if (in >> word) value = std::strtod(word.c_str(), nullptr);
	};
	double bodies = 0, checkpoints = 0;
	get(bodies), get(checkpoints);
	constexpr double kMost = 1e5;
	if (!in || !(bodies >= 1 && bodies < kMost && checkpoints >= 1 && checkpoints < kMost)) return Error{"not a recorded run"};
	MotionRun run;
	run.sizes.resize(size_t(bodies));
	for (double& size : run.sizes) get(size);
	for (int i = 0; i < int(checkpoints) && in; ++i)
	{
		MotionCheckpoint at;
		for (double* value : {&at.time, &at.cost.steps, &at.cost.queries, &at.cost.pairs, &at.cost.seconds}) get(*value);
		at.bodies.resize(size_t(bodies));
		for (MotionState& b : at.bodies)
			for (double* value : {&b.position.x, &b.position.y, &b.position.z, &b.rotation.x, &b.rotation.y, &b.rotation.z, &b.rotation.w,
					 &b.velocity.x, &b.velocity.y, &b.velocity.z, &b.angular.x, &b.angular.y, &b.angular.z})
				get(*value);
		run.checkpoints.push_back(std::move(at));
	}
	if (!in) return Error{"a recorded run ends too early"};
	return run;
}
}  // namespace bench
