// SPDX-License-Identifier: Zlib
// Which bodies and parts the copy of a hand holds, and what a hand does not feel.
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Bullet/BulletShapeParts.h"
#include "DeviceBridge/Bullet/BulletWorldCoupling.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>

namespace devicebridge
{
namespace
{
constexpr double kReach = 0.03;   // extra distance within which bodies are near [m]
constexpr double kHandSpeed = 1;  // tool speed for which a body is known before the tool can reach it within a step [m/s]
constexpr double kLeaveAt = 1.5;  // multiple of the entry distance at which a body leaves

double distanceToBox(const ist::Vec3& p, const btVector3& low, const btVector3& high)
{
	ist::Vec3 d;
	for (int i = 0; i < 3; ++i) d[i] = std::max({double(low[i]) - p[i], 0.0, p[i] - double(high[i])});
	return norm(d);
}
}  // namespace

bool BulletWorldCoupling::isFiniteBody(const btCollisionObject& object)
{
	const btRigidBody* body = btRigidBody::upcast(&object);
	const auto finite = [](const btVector3& v) { return isFinite(toVec3(v)); };
	return isRigid(toRigidPose(object.getWorldTransform())) &&
		(!body || (finite(body->getLinearVelocity()) && finite(body->getAngularVelocity())));
}

/// Whether a part of the tool comes near a box within a step. `share` is a multiple of the distance.
bool BulletWorldCoupling::isNear(const Hand& hand, const ToolPart& part, const btVector3& low, const btVector3& high, double share) const
{
	const double reach = part.radius + kReach + kHandSpeed * m_seconds;
	return distanceToBox(hand.source->mirror().posted().tool.X_WT * part.center, low, high) <= share * reach;
}

bool BulletWorldCoupling::isNear(const Hand& hand, const btCollisionObject& object, double share) const
{
	btVector3 low, high;
	object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
	const std::vector<ToolPart>& parts = hand.source->toolParts();
	return std::any_of(parts.begin(), parts.end(), [&](const ToolPart& part) { return isNear(hand, part, low, high, share); });
}

void BulletWorldCoupling::chooseBodies(Hand& hand)
{
	WorldMirror& mirror = hand.source->mirror();
	for (int slot = 0; slot < mirror.slots(); ++slot)
	{
		Tenant& tenant = hand.tenants[std::size_t(slot)];
		if (mirror.releaseIfDone(slot)) tenant.object = nullptr;
		if (!tenant.object) continue;
		const btCollisionObject& object = *tenant.object;
		const bool stays = isNear(hand, object, kLeaveAt) && isAsAdmitted(tenant) && watches(hand, object, true) && isFiniteBody(object);
		if (!stays) mirror.leave(slot);
	}
	if (!hand.moving) return;
	const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i) admit(hand, *objects[i]);
}

/// Whether a body still has contact response, and its shape still has the parts and the trees with which it entered.
bool BulletWorldCoupling::isAsAdmitted(const Tenant& tenant) const
{
	if (!tenant.object->hasContactResponse()) return false;
	const btISTRegistry& registry = m_registration.registry();
	std::size_t at = 0;
	bool same = true;
	forEachShapePart(registry, *tenant.object->getCollisionShape(), [&](const btCollisionShape& part, const ist::Pose&) {
		same = same && at < tenant.parts.size() && tenant.parts[at].shape == &part && tenant.parts[at].type == part.getShapeType() &&
			tenant.parts[at].tree == registry.find(&part).get();
		++at;
	});
	return same && at == tenant.parts.size();
}

/// Whether the pair filter accepts tool and body. The tool is in no world, so its box is that of its last post.
bool BulletWorldCoupling::watches(const Hand& hand, const btCollisionObject& body, bool was) const
{
	const btISTPairFilter& filter = m_registration.pairFilter();
	const btRigidBody& tool = hand.source->tool();
	if (!filter.acceptsPair(&tool, &body)) return false;
	btVector3 lowerTool, upperTool, lower, upper;
	tool.getCollisionShape()->getAabb(toTransform(hand.source->mirror().posted().tool.X_WT), lowerTool, upperTool);
	body.getCollisionShape()->getAabb(body.getWorldTransform(), lower, upper);
	return filter.acceptsBoxes(lowerTool, upperTool, lower, upper, was);
}

void BulletWorldCoupling::report(const Hand& hand, const btCollisionObject& body, BulletUnfeltBody::Reason reason, bool inPart)
{
	m_unfelt.push_back({&body, hand.source, reason, inPart});
}

void BulletWorldCoupling::admit(Hand& hand, btCollisionObject& object)
{
	WorldMirror& mirror = hand.source->mirror();
	if (!object.hasContactResponse() || &object == &hand.source->tool() || mirror.find(&object) >= 0) return;
	if (!isFiniteBody(object)) return report(hand, object, BulletUnfeltBody::NotFinite, false);
	if (!isNear(hand, object, 1) || !watches(hand, object, false)) return;
	if (object.getInternalType() == btCollisionObject::CO_SOFT_BODY) return report(hand, object, BulletUnfeltBody::NotSupported, false);
	const btISTRegistry& registry = m_registration.registry();
	std::vector<PartKey> parts;
	WorldMirror::Trees trees;
	bool hasModel = false, wasScaled = false;
	forEachShapePart(registry, *object.getCollisionShape(), [&](const btCollisionShape& part, const ist::Pose&) {
		ShapeModel model = ShapeModel::of(registry, part);
		hasModel = hasModel || model.isKnown();
		wasScaled = wasScaled || ShapeModel::wasScaled(registry, part);
		parts.push_back({&part, part.getShapeType(), model.tree.get()});
		if (model.tree) trees.push_back(std::move(model.tree));
	});
	if (!hasModel) return report(hand, object, wasScaled ? BulletUnfeltBody::WasScaled : BulletUnfeltBody::NoModel, false);
	if (trees.empty() && !hand.source->toolTree()) return report(hand, object, BulletUnfeltBody::NoTree, false);
	for (const auto& tree : trees) hand.source->reserve(*tree);
	const int slot = mirror.admit(&object, std::move(trees));
	if (slot < 0)
	{
		++m_crowded;
		return report(hand, object, BulletUnfeltBody::NoSlot, false);
	}
	hand.tenants[std::size_t(slot)] = {&object, std::move(parts), 1};
}

void BulletWorldCoupling::listPairs(Hand& hand, WorldSnapshot& out)
{
	out.pairCount = 0;
	for (int slot = 0; slot < hand.source->mirror().slots(); ++slot)
	{
		const btCollisionObject* object = hand.tenants[std::size_t(slot)].object;
		// The shape of a body that leaves may have been replaced.
		if (object && !hand.source->mirror().body(slot).leaving && isFiniteBody(*object)) listPairs(hand, slot, out);
	}
}

/// Lists the parts of a body that the tool can reach within a step.
void BulletWorldCoupling::listPairs(Hand& hand, int slot, WorldSnapshot& out)
{
	const btCollisionObject& object = *hand.tenants[std::size_t(slot)].object;
	const btISTRegistry& registry = m_registration.registry();
	const std::vector<ToolPart>& tool = hand.source->toolParts();
	bool lacks[4] = {};  // pair, model, tree, tree that fits
	bool felt = false;
	int bodyPart = -1;
	forEachShapePart(registry, *object.getCollisionShape(), [&](const btCollisionShape& shape, const ist::Pose& X_BS) {
		++bodyPart;
		btVector3 low, high;
		shape.getAabb(object.getWorldTransform() * toTransform(X_BS), low, high);
		std::optional<ShapeModel> model;
		for (std::size_t i = 0; i < tool.size(); ++i)
		{
			if (!isNear(hand, tool[i], low, high, kLeaveAt)) continue;
			if (!model) model = ShapeModel::of(registry, shape);
			const bool known = model->isKnown(), hasTree = model->tree || tool[i].tree;
			const bool full = out.pairCount == static_cast<int>(out.pairs.size());
			if (!known) lacks[ShapeModel::wasScaled(registry, shape) ? 3 : 1] = true;
			lacks[2] = lacks[2] || (known && !hasTree);
			if (!known || !hasTree) continue;
			lacks[0] = lacks[0] || full;
			if (full) continue;
			MirroredPair& pair = out.pairs[std::size_t(out.pairCount++)];
			pair.slot = slot;
			pair.toolPart = static_cast<int>(i);
			pair.bodyPart = bodyPart;
			pair.tree = model->tree.get();
			pair.field = model->field;
			pair.X_BP = X_BS * model->X_SP;
			setConstants(hand, object, pair, *model);
			felt = true;
		}
	});
	const BulletUnfeltBody::Reason reasons[] = {
		BulletUnfeltBody::NoPair, BulletUnfeltBody::NoModel, BulletUnfeltBody::NoTree, BulletUnfeltBody::WasScaled};
	for (int i = 0; i < 4; ++i)
		if (lacks[i]) report(hand, object, reasons[i], felt);
}

/// The constants of a pair, decided as for bodies of the world. A has a tree.
void BulletWorldCoupling::setConstants(const Hand& hand, const btCollisionObject& body, MirroredPair& out, const ShapeModel& model) const
{
	const ToolPart& part = hand.source->toolParts()[std::size_t(out.toolPart)];
	const btRigidBody& tool = hand.source->tool();
	const bool toolIsA = part.tree != nullptr;
	btISTContact pair;
	pair.treeA = toolIsA ? part.tree : model.tree;
	pair.treeB = toolIsA ? model.tree : nullptr;
	const ist::AnyField& fieldB = toolIsA ? model.field : part.field;
	pair.halfSpace = !pair.treeB && std::holds_alternative<ist::HalfSpaceField>(fieldB);
	if (!pair.treeB) pair.volumeB = ist::fieldIn(fieldB)->volume();
	// The rule asks a contact whether its surfaces press; here they will.
	const bool flatB = pair.treeB ? !pair.treeB->surface.empty() : ist::fieldIn(fieldB)->isPlanar();
	if (!pair.treeA->surface.empty() && flatB) pair.total.surfaceVolume = 1;
	const btISTPairConstants constants = toolIsA ? m_rule.decide(pair, &tool, &body) : m_rule.decide(pair, &body, &tool);
	out.k = constants.k;
	out.toolWeight = toolIsA ? constants.weightA : constants.weightB;
	out.dissipation = constants.dissipation;
	out.restDepth = constants.load > 0 ? constants.depth : 0;
}

const char* BulletUnfeltBody::adviceFor(Reason reason)
{
	switch (reason)
	{
	case NoSlot: return "all slots of the hand are taken: raise BulletDecoupledSettings::slots";
	case NoPair: return "more parts are near the tool than the hand has room for: raise BulletDecoupledSettings::slots";
	case NoModel:
		return "its shape has no inside that a query knows: attach a tree to the shape (btISTWorld::attach, or for ground "
			   "btISTTreeSource::attachGround)";
	case NoTree: return "neither it nor the tool has a tree: attach a tree to one of the two shapes (btISTWorld::attach)";
	case NotFinite: return "its pose or velocity is not finite, or its axes are not at right angles: correct its transform";
	case NotSupported: return "soft bodies are not felt";
	case WasScaled:
		return "its shape was scaled after its tree was attached: attach a tree for its present size (btISTRegistry::attachScaled or "
			   "btISTTreeSource::attach)";
	}
	return "";
}

std::string BulletWorldCoupling::unfeltReport(const btISTSceneReport::Names& names) const
{
	std::string text;
	for (const BulletUnfeltBody& unfelt : m_unfelt)
	{
		text += names ? names(unfelt.body) : "body " + std::to_string(unfelt.body->getWorldArrayIndex());
		text += unfelt.inPart ? " is not felt in all its parts: " : " is not felt: ";
		text += std::string(BulletUnfeltBody::adviceFor(unfelt.reason)) + "\n";
	}
	for (const Hand& hand : m_hands)
		for (const UnfeltToolPart& part : hand.source->unfeltToolParts())
		{
			text += names ? names(&hand.source->tool()) : "the tool";
			text += " feels nothing with its part " + std::to_string(part.index) + " (" + part.shape + "): ";
			text += part.isHalfSpace
				? "a plane cannot be a part of a tool\n"
				: std::string(BulletUnfeltBody::adviceFor(part.wasScaled ? BulletUnfeltBody::WasScaled : BulletUnfeltBody::NoModel)) +
					", and then make the hand anew\n";
		}
	return text;
}
}  // namespace devicebridge
