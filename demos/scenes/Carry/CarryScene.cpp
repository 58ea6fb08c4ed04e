// SPDX-License-Identifier: Zlib
#include "demos/scenes/Carry/CarryScene.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "demos/scenes/Grasp/GraspObjects.h"

#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

#include <cmath>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr double kTableStiffness = 5e7;
constexpr double kHandLength = 0.189;
constexpr double kLift = 0.1, kAside = 0.1, kTurn = 0.35;  // [m, m, rad]
constexpr double kPassengerX = 0.085;                      // x of nut and ring, from the middle of the beam [m]
constexpr double kPassengerFriction = 0.7;
constexpr int kBeamShare = 4;  // factor for the number of spheres: the beam is so much larger than nut and ring
constexpr double kMasses[CarryScene::kObjects] = {0.18, 0.08, 0.06};  // [kg]

/// Pose of an object's mesh on the beam's, or of the beam's on the table.
Pose standing(CarryScene::Object object)
{
	if (object == CarryScene::kBeam) return {};
	return {{}, {object == CarryScene::kNut ? -kPassengerX : kPassengerX, CarryScene::kHeight, 0}};
}

Twist twistBetween(const Pose& from, const Pose& to, double h)
{
	return {(to.translation - from.translation) / h, rotationVector(quaternion(to.rotation * transpose(from.rotation))) / h};
}

/// Added inertia of an arm in one step, from the springs and dampers of the hand's parts: mass, and inertia about the wrist.
struct Burden
{
	double mass = 0, inertia = 0;
};
Burden burdenOf(const BulletHand& hand, const BulletHandSettings& s, const Vec3& wrist, double h)
{
	Burden sum;
	for (int i = 0; i < kHandParts; ++i)
	{
		const double mass = i == kHandPart ? s.palmMass : s.partMass;
		const double one = h * 2 * std::sqrt(s.stiffness * mass) + h * h * s.stiffness;
		const Vec3 arm = toVec3(hand.body(i).getWorldTransform().getOrigin()) - wrist;
		sum.mass += one;
		sum.inertia += one * dot(arm, arm) + h * h * s.angularStiffness;
	}
	return sum;
}

/// Wrench of the couplings on the hand, about the wrist.
Wrench feltAt(const BulletHand& hand, const Vec3& wrist)
{
	Wrench sum;
	for (int i = 0; i < kHandParts; ++i)
	{
		const Wrench& pull = hand.coupling(i);
		const Vec3 arm = toVec3(hand.body(i).getWorldTransform().getOrigin()) - wrist;
		sum = sum - Wrench{pull.force, pull.torque + cross(arm, pull.force)};
	}
	return sum;
}
}  // namespace

void OperatorArm::step(const Pose& wanted, const Twist& moving, const Wrench& felt, double mass, double inertia, double h) noexcept
{
	// The arm's own spring and damper are evaluated at the end of the step; `wanted` is the pose for that time.
	const auto after = [h](double m, double more, double k, const Vec3& away, const Vec3& v, const Vec3& target, const Vec3& push) {
		const double b = 2 * std::sqrt(k * m);
		return ((m + more) * v + h * (k * away + b * target + push)) / (m + more + h * b + h * h * k);
	};
	const Vec3 turn = rotationVector(quaternion(wanted.rotation * transpose(X_WR.rotation)));
	twist.linear = after(kMass, mass, kStiffness, wanted.translation - X_WR.translation, twist.linear, moving.linear, felt.force);
	twist.angular = after(kInertia, inertia, kAngularStiffness, turn, twist.angular, moving.angular, felt.torque);
	X_WR = {rotationMatrix(quaternionFromRotationVector(h * twist.angular)) * X_WR.rotation, X_WR.translation + h * twist.linear};
	X_WR.rotation = rotationMatrix(quaternion(X_WR.rotation));
}

Result<std::unique_ptr<CarryScene>> CarryScene::make(const CarryOptions& options)
{
	std::unique_ptr<CarryScene> scene(new CarryScene);
	scene->m_options = options;
	for (const bool left : {false, true})
	{
		const Result<HandShape> shape = measureHand(posedHand({}, {left, kHandLength}));
		if (!shape) return shape.error();
		Result<std::shared_ptr<const HandModel>> model = buildHandModel(
			shape.value(), {options.handSpheres, options.cache, 0, options.progress});
		if (!model) return model.error();
		scene->m_models[left] = std::move(model).value();
	}
	const Vec3 half{0.5 * kLength, 0.5 * kHeight, 0.5 * kWidth};
	std::array<Mesh, kObjects> meshes{translated(makeBoxMesh(half), {0, half.y, 0}), {}, {}};
	for (const auto& [object, name] : {std::pair{kNut, "nut"}, std::pair{kRing, "ring"}})
	{
		Result<GraspObject> made = makeGraspObject(name);
		if (!made) return made.error();
		meshes[object] = std::move(made).value().mesh;
	}
	for (int i = 0; i < kObjects; ++i)
	{
		const int64_t spheres = (i == kBeam ? kBeamShare : 1) * options.objectSpheres;
		Result<GraspSolid> solid = GraspSolid::make(std::move(meshes[size_t(i)]), spheres, options.cache, options.progress);
		if (!solid) return solid.error();
		scene->m_solids[size_t(i)] = std::move(solid).value();
	}
	if (auto error = scene->start(options.hands, options.felt)) return *error;
	return scene;
}

CarryScene::~CarryScene() { leave(); }

void CarryScene::leave()
{
	if (!m_world) return;
	m_audit.reset();
	m_hands.clear();
	for (auto& body : m_bodies) body.reset();
	m_world->bullet().removeRigidBody(m_ground.get());
	m_world.reset();
}

std::optional<Error> CarryScene::start(int hands, Felt felt)
{
	if (hands != 1 && hands != 2) return Error{"the beam is carried by one hand or two, not by " + std::to_string(hands)};
	leave();
	m_time = 0;
	m_felt = felt;
	m_world = std::make_unique<btISTWorld>();
	m_groundShape = std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0));
	m_ground = std::make_unique<btRigidBody>(btScalar(0), nullptr, m_groundShape.get());
	m_ground->setFriction(btScalar(1));
	m_world->bullet().addRigidBody(m_ground.get());
	if (auto refused = m_world->materials().set(m_ground.get(), {kTableStiffness, 2})) return refused;
	for (int i = 0; i < kObjects; ++i)
	{
		const double friction = i == kBeam ? m_options.friction : kPassengerFriction;
		Result<std::unique_ptr<GraspBody>> body = GraspBody::make(*m_world, m_solids[size_t(i)], standing(Object(i)), kMasses[i], friction);
		if (!body) return body.error();
		m_bodies[size_t(i)] = std::move(body).value();
	}
	m_hands.reserve(2);
	if (auto error = addHand(false, hands == 2 ? m_options.apart : 0)) return error;
	if (hands == 2)
		if (auto error = addHand(true, -m_options.apart)) return error;
	m_audit = std::make_unique<btEnergyAudit>(m_world->bullet(), m_world->contacts());
	return std::nullopt;
}

std::optional<Error> CarryScene::addHand(bool left, double gripX)
{
	Hand added;
	GraspMotion& m = added.motion;
	m.size = {left, kHandLength};
	m.gripX = gripX;
	m.gripHeight = 0.5 * kHeight;
	m.width = kWidth;
	m.lift = m.turn = m.shake = 0;
	const HandPosture first = m.at(0);
	added.arm.X_WR = first.X_WR;
	Result<std::unique_ptr<BulletHand>> hand = BulletHand::create(*m_world, m_models[left], posedHand(first, m.size), m_options.hand);
	if (!hand) return hand.error();
	added.hand = std::move(hand).value();
	m_hands.push_back(std::move(added));
	return std::nullopt;
}

Pose CarryScene::wantedBeam(double time)
{
	using M = GraspMotion;
	const double up = kLift * smoothShare(time, M::kClosed, M::kLifted) * (1 - smoothShare(time, M::kTurnedBack, M::kPutDown));
	const double there = smoothShare(time, M::kLifted, M::kShaken);
	return {rotationMatrix(quaternionFromRotationVector({0, there * kTurn, 0})), {there * kAside, up, 0}};
}

void CarryScene::step()
{
	const double h = m_options.step;
	for (Hand& h1 : m_hands)
	{
		const auto script = [&](double t) { return wantedBeam(t) * h1.motion.at(t).X_WR; };
		const Pose wanted = script(m_time + h);
		const Vec3 wrist = h1.arm.X_WR.translation;
		Wrench felt;
		if (m_felt != Felt::Nothing) felt.force = h1.felt.force;
		if (m_felt == Felt::ForceAndTorque) felt.torque = h1.felt.torque;
		if (m_felt == Felt::Nothing) h1.arm.X_WR = wanted;
		else
		{
			const Burden burden = burdenOf(*h1.hand, m_options.hand, wrist, h);
			h1.arm.step(wanted, twistBetween(script(m_time), wanted, h), felt, burden.mass, burden.inertia, h);
		}
		HandPosture posture = h1.motion.at(m_time + h);
		posture.X_WR = h1.arm.X_WR;
		h1.hand->drive(posedHand(posture, h1.motion.size), h);
		h1.felt = feltAt(*h1.hand, h1.arm.X_WR.translation);
	}
	m_audit->beforeStep(h);
	m_world->step(h);
	m_audit->afterStep();
	m_time += h;
}

double CarryScene::mass() const { return kMasses[kBeam] + kMasses[kNut] + kMasses[kRing]; }
}  // namespace scenes
