// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Preload/PackingQueue.h"
#include "BulletHapticForce/Preload/PreloadSettings.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Registry/btISTTreeSource.h"

#include <map>
#include <mutex>

class btStridingMeshInterface;

namespace preload
{
/// Volumetric contact for the GImpact meshes of one world of an unmodified game. It is made when the world first steps with such a mesh
/// in it; until then the world is not changed.
class World
{
public:
	/// True when the world contains a GImpact mesh. O(objects).
	static bool hasGImpact(const btDiscreteDynamicsWorld& world);

	World(btDiscreteDynamicsWorld& world, const Settings& settings);
	/// Returns the solver and the dispatch tables to the game. The world must still exist. Shapes and bodies must exist only as far as
	/// Bullet itself needs them.
	~World();

	/// Reason why the world was left unchanged; empty when it was changed.
	const std::string& refusal() const { return m_ist->solverRefusal(); }
	/// Call this before each step. It finds new shapes, forgets shapes that have left the world, and attaches trees that are ready.
	void beforeStep();
	bool uses(const void* part) const { return part == m_dispatcher || part == m_gamesSolver; }
	/// Stops all building of trees, for good. May be called from any thread; it waits for a `beforeStep` in progress.
	void stopBuilding();

private:
	/// Properties that distinguish a shape from a later one at the same address, or from itself after its triangles have changed.
	struct Likeness
	{
		const btStridingMeshInterface* mesh = nullptr;
		btVector3 lower, upper;
		explicit Likeness(const btCollisionShape& shape);
		bool operator==(const Likeness& other) const { return mesh == other.mesh && lower == other.lower && upper == other.upper; }
	};
	struct Entry
	{
		Likeness likeness;
		std::string order;  // key of the tree while the packer makes it; empty before and after
		btISTPendingAttachment attachment;
		uint64_t seen = 0;  // number of the step in which the shape was last in the world
		int changes = 0;
		bool reported = false;
		bool isWaiting() const { return !order.empty() || attachment.isPending(); }
	};
	void see(const btCollisionShape* shape);
	/// Orders the shape's tree from the packer, or else from `m_trees`.
	void orderTree(const btCollisionShape* shape, Entry& entry);
	void forgetUnseen();
	/// Loads the trees that the packer has made.
	void fetchPacked();
	/// Whether the packer makes the tree of a shape.
	bool hasOrders() const;
	size_t waiting() const;
	/// Gives bodies with a mesh the stiffness of the settings, and forgets bodies that have left the world.
	void setStiffness();
	/// Reports how many new meshes wait for their trees.
	void announce();
	void report();
	/// Reports, once, that nothing in this world has become volumetric.
	void conclude();

	btDiscreteDynamicsWorld& m_world;
	const Settings& m_settings;
	const void *m_dispatcher, *m_gamesSolver;
	std::optional<btISTWorld> m_ist;
	std::optional<btISTTreeSource> m_trees;
	PackingQueue m_queue;
	std::map<const btCollisionShape*, Entry> m_shapes;
	std::mutex m_mutex;  ///< needed because a program may exit in one thread while another one steps
	uint64_t m_step = 0;
	size_t m_attached = 0, m_waiting = 0;
	bool m_everVolumetric = false, m_concluded = false;
	std::map<const btCollisionObject*, uint64_t> m_stiffened;  ///< number of the step in which each body was last seen
};
}  // namespace preload
