// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Preload/PreloadSettings.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Registry/btISTTreeSource.h"

#include <map>
#include <mutex>

class btStridingMeshInterface;

namespace preload
{
/// Volumetric contact for the GImpact meshes of one world of a game that knows nothing of it. Made when the world steps with such a mesh in
/// it for the first time; before that the world is not touched.
class World
{
public:
	/// Whether anything in the world can be helped. O(objects).
	static bool hasGImpact(const btDiscreteDynamicsWorld& world);

	World(btDiscreteDynamicsWorld& world, const Settings& settings);
	/// The game gets back its solver and its tables. The world must live; shapes and bodies need not, where Bullet does not need them
	/// either.
	~World();

	/// Why the world was left as it is; empty when it was not.
	const std::string& refusal() const { return m_ist->solverRefusal(); }
	/// Before each step: new shapes are looked for, those that nobody uses any more forgotten, trees that are ready attached.
	void beforeStep();
	bool uses(const void* part) const { return part == m_dispatcher || part == m_gamesSolver; }
	/// Nothing is built any more from here on. Of any thread; waits for a `beforeStep` in progress.
	void stopBuilding();

private:
	/// By which a shape is told from another one at the same address, or from itself with other triangles.
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
		btISTPendingAttachment attachment;
		uint64_t seen = 0;  // step
		int changes = 0;
		bool reported = false;
	};
	void see(const btCollisionShape* shape);
	/// Gives bodies with a mesh the stiffness of the settings, and forgets those that have left the world.
	void setStiffness();
	/// Says how many meshes have come that must wait for their trees.
	void announce();
	void report();
	/// Says what has become of this world when nothing more can.
	void conclude();

	btDiscreteDynamicsWorld& m_world;
	const Settings& m_settings;
	const void *m_dispatcher, *m_gamesSolver;
	std::optional<btISTWorld> m_ist;
	std::optional<btISTTreeSource> m_trees;
	std::map<const btCollisionShape*, Entry> m_shapes;
	std::mutex m_mutex;  ///< a program may end in one thread while it steps in another
	uint64_t m_step = 0;
	size_t m_attached = 0, m_waiting = 0;
	bool m_everVolumetric = false, m_concluded = false;
	std::map<const btCollisionObject*, uint64_t> m_stiffened;  ///< the step in which each was last seen
};
}  // namespace preload
