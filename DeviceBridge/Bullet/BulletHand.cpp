// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletHand.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btConvexHullShape.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace devicebridge
{
namespace
{
std::optional<Error> checkSettings(const BulletHandSettings& s)
{
	const std::pair<const char*, double> positives[] = {{"partMass", s.partMass}, {"palmMass", s.palmMass}, {"stiffness", s.stiffness},
		{"angularStiffness", s.angularStiffness}, {"maxForce", s.maxForce}, {"maxTorque", s.maxTorque}, {"palmForce", s.palmForce},
		{"palmTorque", s.palmTorque}, {"tracking.speed", s.tracking.speed}, {"tracking.turning", s.tracking.turning},
		{"tracking.fade", s.tracking.fade}};
	for (const auto& [name, value] : positives)
		if (!(value > 0) || !std::isfinite(value)) return Error{std::string("the hand's ") + name + " must be a positive finite number"};
	for (const auto& [name, value] : {std::pair{"friction", s.friction}, {"tracking.patience", s.tracking.patience}})
		if (!(value >= 0) || !std::isfinite(value))
			return Error{std::string("the hand's ") + name + " must be a finite number, not negative"};
	return std::nullopt;
}
}  // namespace

Result<std::unique_ptr<BulletHand>> BulletHand::create(
	btISTWorld& world, std::shared_ptr<const HandModel> model, const HandState& start, const BulletHandSettings& settings)
{
	if (!model) return Error{"a hand needs a model: buildHandModel makes one"};
	if (auto error = checkSettings(settings)) return *error;
	if (start.left != model->shape.left)
		return Error{std::string("the model is of a ") + (model->shape.left ? "left" : "right") + " hand and the first sample of a " +
			(start.left ? "left" : "right") + " one"};
	if (const HandSampleFault fault = faultOf(start, model->shape); fault != HandSampleFault::None)
		return Error{std::string("the first sample of the hand cannot be used: ") + describe(fault)};
	const HandPartPoses poses = handPartPoses(*model, start);
	std::unique_ptr<BulletHand> hand(new BulletHand(world, model));
	for (int i = 0; i < kHandParts; ++i)
	{
		if (!poses.known[static_cast<std::size_t>(i)])
			return Error{"the first sample of the hand does not know where " + handPartName(i, start.left) +
				" is: begin when all joints are tracked"};
		if (auto error = hand->addPart(i, poses.X_WB[static_cast<std::size_t>(i)], settings)) return *error;
	}
	for (int i = 1; i < kHandParts; ++i)
	{
		hand->body(i).setIgnoreCollisionCheck(&hand->body(parentOf(i)), true);
		hand->body(parentOf(i)).setIgnoreCollisionCheck(&hand->body(i), true);
	}
	hand->m_monitor = std::make_unique<HandTrackingMonitor>(*hand->m_model, poses, settings.tracking);
	return hand;
}

BulletHand::~BulletHand()
{
	for (Part& part : m_parts)
	{
		if (!part.body) continue;
		m_world.bullet().removeRigidBody(part.body.get());
		m_world.materials().remove(part.body.get());
	}
}

std::optional<Error> BulletHand::addPart(int index, const Pose& X_WB, const BulletHandSettings& settings)
{
	const HandModel::Part& made = m_model->parts[static_cast<std::size_t>(index)];
	Part part;
	auto hull = std::make_unique<btConvexHullShape>();
	for (const Vec3& p : made.mesh.vertices) hull->addPoint(toBullet(p), false);
	hull->setMargin(btScalar(1e-3));
	hull->recalcLocalAabb();
	part.shape = std::move(hull);
	part.mass = index == kHandPart ? settings.palmMass : settings.partMass;
	// The coupling takes a single inertia, so the body has one, too: the largest of its shape.
	const Mat3& shape = made.tree->inertia;
	part.inertia = part.mass / made.tree->volume * std::max({shape.m[0][0], shape.m[1][1], shape.m[2][2]});
	part.gains = {settings.stiffness, settings.angularStiffness, 2 * std::sqrt(settings.stiffness * part.mass),
		2 * std::sqrt(settings.angularStiffness * part.inertia), index == kHandPart ? settings.palmForce : settings.maxForce,
		index == kHandPart ? settings.palmTorque : settings.maxTorque};
	const btScalar inertia = btScalar(part.inertia);
	part.body = std::make_unique<btRigidBody>(btScalar(part.mass), nullptr, part.shape.get(), btVector3(inertia, inertia, inertia));
	part.body->setWorldTransform(toTransform(X_WB));
	part.body->setInterpolationWorldTransform(toTransform(X_WB));
	part.body->setFriction(btScalar(settings.friction));
	part.body->setActivationState(DISABLE_DEACTIVATION);
	part.body->setFlags(part.body->getFlags() | BT_DISABLE_WORLD_GRAVITY);
	Result<btISTAttachment> attached = m_world.attach(part.shape.get(), made.tree);
	if (!attached) return attached.error();
	part.attachment = std::move(attached).value();
	if (auto refused = m_world.materials().set(part.body.get(), settings.skin)) return refused;
	m_world.bullet().addRigidBody(part.body.get());
	part.body->setGravity(btVector3(0, 0, 0));
	m_parts[static_cast<std::size_t>(index)] = std::move(part);
	return std::nullopt;
}

void BulletHand::drive(const HandState& hand, double h) noexcept
{
	if (!(h > 0) || !std::isfinite(h)) return;
	m_monitor->update(hand, h);
	for (int i = 0; i < kHandParts; ++i)
	{
		Part& part = m_parts[static_cast<std::size_t>(i)];
		CouplingGains gains = part.gains;
		// The dampers stay, so that a hand that has released its grip comes to rest.
		gains.stiffness *= m_monitor->grip();
		gains.angularStiffness *= m_monitor->grip();
		const HandTrackingMonitor::Target& target = m_monitor->target(i);
		const ToolState tool{
			toPose(part.body->getWorldTransform()), {toVec3(part.body->getLinearVelocity()), toVec3(part.body->getAngularVelocity())}};
		part.coupling = couplingOnTool(gains, target.X_WB, target.twist, tool, part.mass, part.inertia, h);
		if (!isFinite(part.coupling)) part.coupling = {};
		part.body->applyCentralForce(toBullet(part.coupling.force));
		part.body->applyTorque(toBullet(part.coupling.torque));
	}
}

int BulletHand::partOf(const btCollisionObject* object) const noexcept
{
	for (int i = 0; i < kHandParts; ++i)
		if (m_parts[static_cast<std::size_t>(i)].body.get() == object) return i;
	return -1;
}

BulletHand::Touch BulletHand::touch(double h, const btCollisionObject* only) const noexcept
{
	Touch touch;
	bool touches[kHandParts] = {};
	const btISTContactStore& store = m_world.contacts();
	for (const btISTContact* contact : store.contacts())
	{
		if (!touchedInLastStep(store, *contact)) continue;
		if (only && contact->bodyA != only && contact->bodyB != only) continue;
		const int a = partOf(contact->bodyA), b = partOf(contact->bodyB);
		if (a < 0 && b < 0) continue;
		Vec3 onA;
		for (int i = 0; i < contact->patchCount; ++i) onA += contact->impulses[i].force / h;
		touch.pairs += contact->total.pairs;
		if (a >= 0) touch.force[a] += onA;
		if (b >= 0) touch.force[b] -= onA;
		if (a >= 0 && b >= 0)
		{
			++touch.selfContacts;
			touch.selfForce += norm(onA);
			continue;
		}
		touches[a >= 0 ? a : b] = true;
	}
	touch.parts = static_cast<int>(std::count(touches, touches + kHandParts, true));
	return touch;
}
}  // namespace devicebridge
