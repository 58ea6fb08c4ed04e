// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Preload/PreloadWorld.h"

#include "BulletISTCollision/Registry/btISTShapeMesh.h"

#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <set>
#include <thread>
#include <utility>

namespace preload
{
namespace
{
// Limit on changes of a mesh: without it, triangles that move would be packed again and again.
constexpr int kMostChanges = 3;

bool isMesh(const btCollisionShape& shape)
{
	return shape.getShapeType() == GIMPACT_SHAPE_PROXYTYPE &&
		static_cast<const btGImpactShapeInterface&>(shape).getGImpactShapeType() != CONST_GIMPACT_COMPOUND_SHAPE;
}

/// Visits every GImpact mesh of a shape: the shape itself, or the children of a compound.
template <class Visit> void forEachMesh(const btCollisionShape* shape, const Visit& visit)
{
	if (shape->getShapeType() == COMPOUND_SHAPE_PROXYTYPE)
	{
		const auto* compound = static_cast<const btCompoundShape*>(shape);
		for (int i = 0; i < compound->getNumChildShapes(); ++i) forEachMesh(compound->getChildShape(i), visit);
	}
	else if (isMesh(*shape)) visit(shape);
}

template <class Visit> void forEachMesh(const btDiscreteDynamicsWorld& world, const Visit& visit)
{
	const btCollisionObjectArray& objects = world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i) forEachMesh(objects[i]->getCollisionShape(), visit);
}

btISTTreeSettings treeSettings(const Settings& settings)
{
	btISTTreeSettings result;
	result.build = buildOptions(settings.spheres);
	result.cacheFolder = settings.cacheFolder;
	return result;
}
}  // namespace

World::Likeness::Likeness(const btCollisionShape& shape)
{
	const auto& gimpact = static_cast<const btGImpactShapeInterface&>(shape);
	if (gimpact.getGImpactShapeType() == CONST_GIMPACT_TRIMESH_SHAPE)
		mesh = static_cast<const btGImpactMeshShape&>(shape).getMeshInterface();
	shape.getAabb(btTransform::getIdentity(), lower, upper);
}

bool World::hasGImpact(const btDiscreteDynamicsWorld& world)
{
	bool found = false;
	forEachMesh(world, [&found](const btCollisionShape*) { found = true; });
	return found;
}

World::World(btDiscreteDynamicsWorld& world, const Settings& settings)
	: m_world(world),
	  m_settings(settings),
	  m_dispatcher(world.getDispatcher()),
	  m_gamesSolver(world.getConstraintSolver()),
	  m_queue(settings)
{
	m_ist.emplace(world);
	m_trees.emplace(m_ist->registration().registry(), treeSettings(settings));
}

World::~World()
{
	// All pairs are cleaned at once, because a test per pair would read shapes that may be deleted. If the world was refused, no pair is
	// ours, and the registration may be with another dispatcher than the pairs' algorithms. If no contact is left, the game may have
	// deleted the broad phase before the world, so it is not touched.
	if (refusal().empty() && !m_ist->contacts().contacts().empty()) m_ist->registration().cleanPairs(m_world.getPairCache());
	(void)m_ist->registration().setPairCache(nullptr);
	conclude();
	m_shapes.clear();
	m_trees.reset();
	if (m_everVolumetric) say(m_settings, 2, "a world goes, and volumetric contact with it");
}

void World::see(const btCollisionShape* shape)
{
	const auto found = m_shapes.find(shape);
	const Likeness likeness(*shape);
	if (found != m_shapes.end() && found->second.likeness == likeness)
	{
		found->second.seen = m_step;
		return;
	}
	const int changes = found == m_shapes.end() ? 0 : found->second.changes + 1;
	if (found != m_shapes.end()) m_shapes.erase(found);
	Entry entry{likeness, {}, {}, m_step, changes};
	if (changes <= kMostChanges && m_trees) orderTree(shape, entry);
	if (changes == kMostChanges + 1) say(m_settings, 1, "a mesh whose triangles move stays GImpact's");
	m_shapes.emplace(shape, std::move(entry));
}

void World::orderTree(const btCollisionShape* shape, Entry& entry)
{
	if (ist::Result<ist::Mesh> mesh = meshOfShape(*shape)) entry.order = m_queue.order(std::move(mesh).value());
	if (entry.order.empty()) entry.attachment = m_trees->attach(shape);
}

void World::forgetUnseen()
{
	std::set<std::string> unseen;
	for (auto i = m_shapes.begin(); i != m_shapes.end();)
	{
		const bool gone = i->second.seen != m_step;
		if (gone && !i->second.order.empty()) unseen.insert(i->second.order);
		i = gone ? m_shapes.erase(i) : std::next(i);
	}
	if (unseen.empty()) return;
	for (const auto& [shape, entry] : m_shapes) unseen.erase(entry.order);
	for (const std::string& order : unseen) m_queue.withdraw(order);
}

void World::fetchPacked()
{
	std::set<std::string> orders;
	for (const auto& [shape, entry] : m_shapes)
		if (!entry.order.empty()) orders.insert(entry.order);
	for (const std::string& over : m_queue.over({orders.begin(), orders.end()}))
		for (auto& [shape, entry] : m_shapes)
			if (entry.order == over)
			{
				entry.order.clear();
				entry.attachment = m_trees->attach(shape);
			}
}

bool World::hasOrders() const
{
	return std::any_of(m_shapes.begin(), m_shapes.end(), [](const auto& each) { return !each.second.order.empty(); });
}

size_t World::waiting() const
{
	return size_t(std::count_if(m_shapes.begin(), m_shapes.end(), [](const auto& each) { return each.second.isWaiting(); }));
}

void World::stopBuilding()
{
	const std::lock_guard lock(m_mutex);
	conclude();
	m_trees.reset();
}

void World::conclude()
{
	if (std::exchange(m_concluded, true) || !refusal().empty()) return;
	const size_t waits = waiting();
	const std::string hint = " (BULLETHAPTICS_WAIT=1 waits for them)" +
		std::string(hasOrders() ? "; bullethaptics-pack goes on with them, for the next run" : "");
	if (waits > 0 && !m_everVolumetric) say(m_settings, 1, "trees were not ready: nothing was volumetric" + hint);
	else if (waits > 0) say(m_settings, 1, "trees of " + std::to_string(waits) + " meshes were not ready" + hint);
	else if (!m_everVolumetric) say(m_settings, 2, "a world goes, and nothing in it was volumetric");
}

void World::setStiffness()
{
	const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i)
	{
		bool isMeshed = false;
		forEachMesh(objects[i]->getCollisionShape(), [&isMeshed](const btCollisionShape*) { isMeshed = true; });
		if (!isMeshed) continue;
		const bool isNew = m_stiffened.insert_or_assign(objects[i], m_step).second;
		if (isNew) (void)m_ist->materials().set(objects[i], {m_settings.stiffness});  // the settings contain only values that `set` accepts
	}
	for (auto i = m_stiffened.begin(); i != m_stiffened.end();)
	{
		if (i->second != m_step) m_ist->materials().remove(i->first);
		i = i->second == m_step ? std::next(i) : m_stiffened.erase(i);
	}
}

void World::announce()
{
	const size_t now = waiting();
	const std::string found = std::to_string(now) + " GImpact meshes found, trees are being packed";
	if (now > m_waiting) say(m_settings, 1, found + (m_settings.waits ? "; the step waits" : ""));
	m_waiting = now;
}

void World::beforeStep()
{
	const std::lock_guard lock(m_mutex);
	++m_step;
	// the game registered GImpact after our registration
	if (!m_ist->registration().isRegistered()) (void)m_ist->registration().reinstall();
	forEachMesh(m_world, [this](const btCollisionShape* shape) { see(shape); });
	forgetUnseen();
	if (m_settings.stiffness > 0) setStiffness();
	if (!m_trees) return;
	announce();
	for (fetchPacked(); m_settings.waits && hasOrders(); fetchPacked()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
	if (m_settings.waits) m_trees->finish();
	else m_trees->update();
	report();
}

void World::report()
{
	size_t attached = 0, waiting = 0;
	for (auto& [shape, entry] : m_shapes)
	{
		attached += entry.attachment.isAttached();
		waiting += entry.isWaiting();
		if (entry.reported || entry.isWaiting()) continue;
		entry.reported = true;
		if (!entry.attachment.error().empty()) say(m_settings, 1, "a mesh stays GImpact's: " + entry.attachment.error());
		if (!entry.attachment.note().empty()) say(m_settings, 2, entry.attachment.note());
		if (entry.attachment.isAttached()) say(m_settings, 2, "a mesh has its tree");
	}
	m_everVolumetric = m_everVolumetric || attached > 0;
	if (waiting > 0 || attached == m_attached) return;
	m_attached = attached;
	int bodies = 0;
	const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i)
	{
		bool volumetric = false;
		forEachMesh(objects[i]->getCollisionShape(),
			[&](const btCollisionShape* shape) { volumetric = volumetric || m_shapes.at(shape).attachment.isAttached(); });
		bodies += volumetric;
	}
	say(m_settings, 1,
		std::to_string(bodies) + " GImpact bodies of " + std::to_string(attached) + " meshes have volumetric contact from step " +
			std::to_string(m_step) + " on");
}
}  // namespace preload
