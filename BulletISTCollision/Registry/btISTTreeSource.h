// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Build/TreeWorker.h"
#include "BulletISTCollision/Registry/btISTRegistry.h"
#include "BulletISTCollision/Registry/btPrecisionGuard.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

class btCollisionWorld;

struct btISTTreeSettings
{
	/// Settings of all trees that are built from shapes. One thread by default, so that the game keeps the other cores.
	ist::BuildOptions build = [] {
		ist::BuildOptions o;
		o.maxSpheres = 3000;
		o.threads = 1;
		return o;
	}();
	/// Folder that keeps built trees from one run of the program to the next; empty: no cache.
	std::string cacheFolder;
	/// Largest doubtful share of the volume of a mesh that is not closed (see ist::cachedTree).
	double mostDoubt = 0.05;
};

/// A tree that is being loaded or built for a shape, and later its attachment. Keep it for as long as the shape is to be volumetric, and
/// destroy it before the shape. Until the tree is ready, Bullet's own contact is used. Move-only; may outlive its source.
class [[nodiscard]] btISTPendingAttachment
{
public:
	btISTPendingAttachment() = default;

	bool isAttached() const;
	/// True while it is neither attached nor failed.
	bool isPending() const;
	/// The reason why there will be no tree; empty otherwise.
	const std::string& error() const;
	/// A message for developers: why the cache could not be used. Empty otherwise.
	const std::string& note() const;
	/// The tree; null before it is attached.
	std::shared_ptr<const ist::InnerSphereTree> tree() const;
	const btCollisionShape* shape() const;
	/// Detaches the tree, or stops waiting for it.
	void detach() { m_state.reset(); }

private:
	friend class btISTTreeSource;
	struct State;
	explicit btISTPendingAttachment(std::unique_ptr<State> state);
	struct Deleter
	{
		void operator()(State* state) const;
	};
	std::unique_ptr<State, Deleter> m_state;
};

/// Source of the trees of a game that does not load them itself. A tree comes from an asset file, or from the triangles of a shape, which
/// a worker thread packs while the game runs. Built trees are kept in a folder. Shapes with equal triangles share one tree.
///
///     btISTTreeSource trees(world.registration().registry(), settings);
///     auto rocks = trees.attachGImpact(world.bullet());     // once
///     trees.update();                                       // in every frame, before the step
///
/// One owner thread: the world's. The registry must outlive the source.
class btISTTreeSource
{
public:
	explicit btISTTreeSource(btISTRegistry& registry, btISTTreeSettings settings = {});
	/// Cancels what is being built. Attachments that have their tree keep it.
	~btISTTreeSource();
	btISTTreeSource(const btISTTreeSource&) = delete;
	btISTTreeSource& operator=(const btISTTreeSource&) = delete;

	/// Builds from the shape's own triangles (meshOfShape), which are copied before it returns. They include the shape's local scaling,
	/// which must not change. Of a btHeightfieldTerrainShape it makes ground: attachGround(shape).
	btISTPendingAttachment attach(const btCollisionShape* shape);
	/// Builds a body from open ground: a heightfield, or a static triangle mesh whose open surface faces `up` in the shape's frame. The
	/// tree's body reaches from the surface down to a flat bottom `depth` [m] below the lowest vertex (ist::GroundClosing). A depth of 0
	/// stands for a tenth of the surface's longest side. A heightfield has its own axis, and `up` is ignored. The broad phase knows the
	/// shape's own box only, so bodies wholly below it touch nothing.
	btISTPendingAttachment attachGround(const btCollisionShape* shape, double depth = 0, ist::SignedAxis up = {});
	/// Loads an .ist file for a shape whose local scaling is 1.
	btISTPendingAttachment attachAsset(const btCollisionShape* shape, const std::string& path);
	/// Loads an .ist file for the shape of this name in a loaded .bullet file, or else for the shape of the body of this name. `importer`
	/// is Bullet's btBulletWorldImporter, or has the same `getCollisionShapeByName` and `getRigidBodyByName`.
	template <class Importer> btISTPendingAttachment attachAsset(Importer& importer, const char* name, const std::string& path)
	{
		const btCollisionShape* shape = shapeNamed(importer, name);
		return shape ? attachAsset(shape, path) : unknown(name);
	}
	/// Like the function above, but builds from the shape's own triangles.
	template <class Importer> btISTPendingAttachment attach(Importer& importer, const char* name)
	{
		const btCollisionShape* shape = shapeNamed(importer, name);
		return shape ? attach(shape) : unknown(name);
	}
	/// Loads every file NAME.ist of a folder for the shape or body of that name, if the loaded file has one.
	template <class Importer> [[nodiscard]] std::vector<btISTPendingAttachment> attachFolder(Importer& importer, const std::string& folder)
	{
		std::vector<btISTPendingAttachment> result;
		for (const std::string& name : assetNames(folder))
			if (const btCollisionShape* shape = shapeNamed(importer, name.c_str()))
				result.push_back(attachAsset(shape, folder + "/" + name + ".ist"));
		return result;
	}
	/// Builds trees for all GImpact meshes among the shapes of a world's objects, children of btCompoundShapes included, that have no
	/// tree and wait for none. Children of a btGImpactCompoundShape are left out, because their contact stays Bullet's.
	[[nodiscard]] std::vector<btISTPendingAttachment> attachGImpact(const btCollisionWorld& world);

	/// From now on a tree is loaded or built only when another object comes near an object of this world that has the shape. Near means
	/// that the broad phase finds it within one longest side of the object's bounding box. Until then only the triangles are kept.
	/// Earlier orders go on. The world must live for as long as `update` is called. Null (default): trees are ordered at once.
	void orderWhenNear(const btCollisionWorld* world) { m_near = world; }

	/// Attaches the trees that are ready; call it between two steps. Returns the number of shapes attached. Does not wait. O(waiting
	/// shapes), and O(objects) while some shapes wait for neighbours.
	int update();
	/// Waits until every tree is ready or has failed, near or far, and attaches them. Meant for loading screens and tests.
	int finish();
	/// Number of shapes that still wait.
	int pending() const;
	/// Number of waiting shapes that no object has come near to.
	int waitingForNeighbours() const;

private:
	friend class btISTPendingAttachment;
	template <class Importer> static const btCollisionShape* shapeNamed(Importer& importer, const char* name)
	{
		if (const btCollisionShape* shape = importer.getCollisionShapeByName(name)) return shape;
		const btRigidBody* body = importer.getRigidBodyByName(name);
		return body ? body->getCollisionShape() : nullptr;
	}
	static btISTPendingAttachment refused(const btCollisionShape* shape, const std::string& error);
	static btISTPendingAttachment unknown(const char* name);
	/// Names without extension, sorted; empty if the folder cannot be read.
	static std::vector<std::string> assetNames(const std::string& folder);
	using Start = std::function<std::shared_ptr<const ist::TreeOrder>()>;
	btISTPendingAttachment build(const btCollisionShape* shape, ist::Mesh mesh, const ist::BuildOptions& options);
	btISTPendingAttachment expect(const btCollisionShape* shape, const btVector3& scaling, Start start);
	bool hasNeighbour(const btCollisionObject& object) const;
	void orderWhatIsNear();
	void collectGImpact(const btCollisionShape* shape, std::vector<btISTPendingAttachment>& into);
	bool awaits(const btCollisionShape* shape) const;

	struct Waiting;
	btISTRegistry& m_registry;
	btISTTreeSettings m_settings;
	std::shared_ptr<Waiting> m_waiting;
	std::unique_ptr<ist::TreeWorker> m_worker;
	const btCollisionWorld* m_near = nullptr;
};
