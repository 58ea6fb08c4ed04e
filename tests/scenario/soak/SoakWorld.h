// SPDX-License-Identifier: Zlib
#pragma once

#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/ISTCollision/Registry/BulletMesh.h"

#include <list>
#include <memory>
#include <optional>
#include <random>
#include <vector>

/// Random scenes for the soak: what lives in them, and what must be true of it.
namespace soak
{
using Random = std::mt19937_64;
inline double between(Random& random, double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
inline int below(Random& random, int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }

/// Solids of a few spheres, all about a metre wide; made once, shared by all worlds.
struct Solids
{
	scenario::Solid cube, ring, cone;
	BulletMesh ringTriangles;
	btConvexHullShape coneHull;
	Solids();
	const scenario::Solid& of(int kind) const { return kind == 1 ? ring : kind == 2 ? cone : cube; }
	static constexpr int kCount = 3;
};

/// A body with all that it needs. Its parts can carry trees, if they are of one of the solids.
struct Actor
{
	struct Part
	{
		std::unique_ptr<btCollisionShape> shape;
		int solid = -1;
		btISTAttachment attachment;
	};
	std::vector<Part> parts;
	std::unique_ptr<btCompoundShape> compound;  // of the parts, where they are several
	std::unique_ptr<btRigidBody> body;
	bool poisoned = false;  // or touched, in Bullet's own way, by one that is

	bool isFinite() const;
	btCollisionShape* shape() const { return compound ? static_cast<btCollisionShape*>(compound.get()) : parts[0].shape.get(); }
};

enum class WorldKind
{
	Own,         ///< of btISTWorld
	Sequential,  ///< of a game, with each of the solvers that ours can take the place of
	Nncg,
	MultiBody,
	Count
};

/// A pit of five planes, bodies, joints, and volumetric contact in all of it.
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

	/// Of solids, or of Bullet's own shapes.
	Actor& add(Random& random, bool volumetric);
	void remove(Actor& actor);
	void attach(Actor::Part& part);
	void join(Actor& a, Actor& b);
	void separate();
	/// Takes our lines out of the game's world, and puts them in again, around bodies that stay.
	void reinstall();
	void place(Actor& actor, const btTransform& pose);
	btTransform somewhere(Random& random) const;

	/// Marks all that a poisoned body reaches through joints and Bullet's own contact, which hands on whatever it is given, and what was
	/// struck absurdly hard by it.
	void spreadPoison();
	/// Puts every poisoned body back into the pit, and forgets what Bullet kept of its contacts.
	void heal(Random& random);
	/// Kinetic and potential, of all that moves [J].
	double energy() const;
	/// How deep in the floor [m] that energy can press a body's centre of mass. A pressure of k times the depth stores at least k times the
	/// body's volume times the mean depth of its points (Jensen), and weight gives back its own share. Where no k is set it is at least
	/// that of btISTDefaultPairRule for the body alone.
	double deepestWith(double energy, const Actor& actor);
	void step(double h);

private:
	void install();
	void addPlanes();
	/// Whether nothing but our contact was between the two in the last step.
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
