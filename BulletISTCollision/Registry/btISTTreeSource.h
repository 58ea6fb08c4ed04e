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
	/// Of all trees that are built from shapes. One thread, so that the game keeps the others.
	ist::BuildOptions build = [] {
		ist::BuildOptions o;
		o.maxSpheres = 3000;
		o.threads = 1;
		return o;
	}();
	/// Where built trees are kept from one run of the program to the next; empty: nowhere.
	std::string cacheFolder;
	/// See ist::cachedTree.
	double mostDoubt = 0.05;
};

/// A tree that is on its way to a shape, then its attachment: keep it for as long as the shape is to be volumetric, and destroy it
/// before the shape. Until the tree is there Bullet's own contact goes on. Move-only; may outlive its source.
class [[nodiscard]] btISTPendingAttachment
{
public:
	btISTPendingAttachment() = default;

	bool isAttached() const;
	/// Neither attached nor failed.
	bool isPending() const;
	/// Why there is and will be no tree; empty otherwise.
	const std::string& error() const;
	/// What to tell a developer: why the cache could not be used. Empty otherwise.
	const std::string& note() const;
	/// Null before it is attached.
	std::shared_ptr<const ist::InnerSphereTree> tree() const;
	const btCollisionShape* shape() const;
	/// Detaches, or stops waiting.
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

/// Where the trees of a game come from when it does not load them itself: asset files, or the triangles that its shapes have already,
/// packed by a worker thread while the game runs and kept in a folder. Shapes of equal triangles share one tree.
///
///     btISTTreeSource trees(world.registration().registry(), settings);
///     auto rocks = trees.attachGImpact(world.bullet());     // once
///     trees.update();                                       // in every frame, before the step
///
/// One owner thread: that of the world. The registry must outlive it.
class btISTTreeSource
{
public:
	explicit btISTTreeSource(btISTRegistry& registry, btISTTreeSettings settings = {});
	/// Breaks off what is being built. Attachments that have their tree keep it.
	~btISTTreeSource();
	btISTTreeSource(const btISTTreeSource&) = delete;
	btISTTreeSource& operator=(const btISTTreeSource&) = delete;

	/// From the shape's own triangles (meshOfShape), which are copied before it returns. They are those of the shape's local scaling,
	/// which must stay.
	btISTPendingAttachment attach(const btCollisionShape* shape);
	/// From an .ist file, of a shape whose local scaling is 1.
	btISTPendingAttachment attachAsset(const btCollisionShape* shape, const std::string& path);
	/// From an .ist file, to the shape that has this name in a loaded .bullet file, else to that of the body of this name. `importer` is
	/// Bullet's btBulletWorldImporter, or has `getCollisionShapeByName` and `getRigidBodyByName` as it does.
	template <class Importer> btISTPendingAttachment attachAsset(Importer& importer, const char* name, const std::string& path)
	{
		const btCollisionShape* shape = shapeNamed(importer, name);
		return shape ? attachAsset(shape, path) : unknown(name);
	}
	/// The same from the shape's own triangles.
	template <class Importer> btISTPendingAttachment attach(Importer& importer, const char* name)
	{
		const btCollisionShape* shape = shapeNamed(importer, name);
		return shape ? attach(shape) : unknown(name);
	}
	/// Every file NAME.ist of a folder goes to the shape or body of that name, when the loaded file has one.
	template <class Importer> [[nodiscard]] std::vector<btISTPendingAttachment> attachFolder(Importer& importer, const std::string& folder)
	{
		std::vector<btISTPendingAttachment> result;
		for (const std::string& name : assetNames(folder))
			if (const btCollisionShape* shape = shapeNamed(importer, name.c_str()))
				result.push_back(attachAsset(shape, folder + "/" + name + ".ist"));
		return result;
	}
	/// Every GImpact mesh among the shapes of a world's objects, the children of btCompoundShapes too, that has no tree yet and waits for
	/// none. Not the children of a btGImpactCompoundShape: their contact stays Bullet's.
	[[nodiscard]] std::vector<btISTPendingAttachment> attachGImpact(const btCollisionWorld& world);

	/// From now on a tree is loaded or built only when something comes near an object of this world that has the shape: when the broad
	/// phase finds it within one longest side of the object's bounding box. Until then nothing but the triangles is kept. What was ordered
	/// before stays so. The world must live for as long as `update` is called. Null, as it is to begin with: at once.
	void orderWhenNear(const btCollisionWorld* world) { m_near = world; }

	/// Attaches what has become ready, between two steps; gives how many shapes that were. Waits for nobody. O(shapes that wait), and while
	/// some wait for neighbours O(objects).
	int update();
	/// Waits until every tree is there or has failed, near or far, then as `update`: for loading screens and tests.
	int finish();
	/// Shapes that still wait.
	int pending() const;
	/// Of these the ones that nothing has come near to.
	int waitingForNeighbours() const;

private:
	friend class btISTPendingAttachment;
	template <class Importer> static const btCollisionShape* shapeNamed(Importer& importer, const char* name)
	{
		if (const btCollisionShape* shape = importer.getCollisionShapeByName(name)) return shape;
		const btRigidBody* body = importer.getRigidBodyByName(name);
		return body ? body->getCollisionShape() : nullptr;
	}
	static btISTPendingAttachment unknown(const char* name);
	/// Without their ending, sorted; none when the folder cannot be read.
	static std::vector<std::string> assetNames(const std::string& folder);
	using Start = std::function<std::shared_ptr<const ist::TreeOrder>()>;
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
