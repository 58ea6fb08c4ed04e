// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/ISTCollision/Registry/BulletMesh.h"

#include <list>
#include <memory>
#include <optional>
#include <random>
#include <vector>

/// Random scenes for the soak test: their contents, and what must be true of them.
namespace soak
{
using Random = std::mt19937_64;
inline double between(Random& random, double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
inline int below(Random& random, int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }

/// Solids of a few spheres, each about 1 m wide; the cone has no surface. They are made once and shared by all worlds.
struct Solids
{
	scenario::Solid cube, ring, cone;
	BulletMesh ringTriangles;
	btConvexHullShape coneHull;
	Solids();
	const scenario::Solid& of(int kind) const { return kind == 1 ? ring : kind == 2 ? cone : cube; }
	static constexpr int kCount = 3;
};

/// A body with all its parts. Parts that are made from one of the solids can have trees.
struct Actor
{
	struct Part
	{
		std::unique_ptr<btCollisionShape> shape;
		int solid = -1;
		btISTAttachment attachment;
	};
	std::vector<Part> parts;
	std::unique_ptr<btCompoundShape> compound;  // compound of the parts, if there are several
	std::unique_ptr<btRigidBody> body;
	bool poisoned = false;  // true: poisoned, or touched through Bullet's own contact by a poisoned body

	bool isFinite() const;
	btCollisionShape* shape() const { return compound ? static_cast<btCollisionShape*>(compound.get()) : parts[0].shape.get(); }
};

enum class WorldKind
{
	Own,         ///< a world of btISTWorld's own
	Sequential,  ///< a game's world, with each of the solvers that ours can replace
	Nncg,
	MultiBody,
	Count
};

/// A pit of five planes with bodies, joints, and volumetric contact.
class SoakWorld
{
public:
	SoakWorld(WorldKind kind, const Solids& solids, std::vector<scenario::TreePtr> trees);
	~SoakWorld();

	btISTWorld& ist() { return *m_ist; }
	btDiscreteDynamicsWorld& bullet() { return m_game ? *m_game : m_ist->bullet(); }
	WorldKind kind() const { return m_kind; }
	std::list<Actor>& actors() { return m_actors; }
	size_t joints() const { return m_joints.size(); }

	/// Adds a body made of solids, or of Bullet's own shapes.
	Actor& add(Random& random, bool volumetric);
	void remove(Actor& actor);
	void attach(Actor::Part& part);
	void join(Actor& a, Actor& b);
	void separate();
	/// Removes our registration and solver from the game's world and installs them again, while the bodies stay.
	void reinstall();
	void place(Actor& actor, const btTransform& pose);
	btTransform somewhere(Random& random) const;

	/// Marks all bodies that poison reaches. It passes through joints and through Bullet's own contact, which transmits any value. Bodies
	/// that were hit absurdly hard are marked too.
	void spreadPoison();
	/// Puts every poisoned body back into the pit, and removes Bullet's contact points of it.
	void heal(Random& random);
	/// Kinetic and potential energy of all moving bodies [J].
	double energy() const;
	/// Largest depth [m] to which this energy can press a body's centre of mass into the floor. A pressure of k times the depth stores at
	/// least k V d, with V the body's volume and d the mean depth of its points (Jensen). The weight adds its own share. Where k is not
	/// set, it is at least that of btISTDefaultPairRule for the body alone.
	double deepestWith(double energy, const Actor& actor);
	void step(double h);

private:
	void install();
	void addPlanes();
	/// True when only our contact acted between the two bodies in the last step.
	bool isVolumetric(const btBroadphasePair& pair);
	void cleanStockPairs(btRigidBody& body);

	WorldKind m_kind;
	const Solids& m_solids;
	std::vector<scenario::TreePtr> m_trees;
	btDefaultCollisionConfiguration m_configuration;
	btCollisionDispatcher m_dispatcher{&m_configuration};
	btDbvtBroadphase m_broadphase;
	std::unique_ptr<btConstraintSolver> m_solver;
	std::unique_ptr<btDiscreteDynamicsWorld> m_game;
	std::optional<btISTWorld> m_ist;
	std::vector<std::unique_ptr<btStaticPlaneShape>> m_planes;
	std::vector<std::unique_ptr<btRigidBody>> m_walls;
	std::list<Actor> m_actors;
	std::vector<std::unique_ptr<btTypedConstraint>> m_joints;
};
}  // namespace soak
