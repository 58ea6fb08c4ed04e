// SPDX-License-Identifier: Zlib
// A game as there are many around Bullet: GImpact rings, boxes, a hinge, a compound, a static mesh as the ground. It prints where every
// body is after each frame, exactly. With VOLUMETRIC defined it has our lines; `--attach` then gives the rings their trees.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>
#ifdef VOLUMETRIC
#include <BulletHapticForce/btBulletHapticForceCommon.h>
#endif

#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>
#include <vector>

namespace
{
/// A ring around z of 32 by 16 quads, in triangles.
btTriangleMesh* makeRing(double R, double r)
{
	const auto point = [=](int i, int j) {
		const double u = i * 0.19634954084936207, v = j * 0.39269908169872414;
		return btVector3(
			btScalar((R + r * std::cos(v)) * std::cos(u)), btScalar((R + r * std::cos(v)) * std::sin(u)), btScalar(r * std::sin(v)));
	};
	auto* mesh = new btTriangleMesh;
	for (int i = 0; i < 32; ++i)
		for (int j = 0; j < 16; ++j)
		{
			mesh->addTriangle(point(i, j), point(i + 1, j), point(i + 1, j + 1));
			mesh->addTriangle(point(i, j), point(i + 1, j + 1), point(i, j + 1));
		}
	return mesh;
}

btTransform at(double x, double y, double z, double turn = 0)
{
	return btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(turn)), btVector3(btScalar(x), btScalar(y), btScalar(z)));
}
}  // namespace

class Game
{
public:
	Game()
	{
		btGImpactCollisionAlgorithm::registerAlgorithm(&m_dispatcher);
		m_world.setGravity(btVector3(0, -10, 0));
		m_ground.addTriangle(btVector3(-50, 0, -50), btVector3(-50, 0, 50), btVector3(50, 0, 50));
		m_ground.addTriangle(btVector3(-50, 0, -50), btVector3(50, 0, 50), btVector3(50, 0, -50));
		add(shape(new btBvhTriangleMeshShape(&m_ground, true)), 0, at(0, 0, 0));
		add(shape(new btStaticPlaneShape(btVector3(0, 1, 0), btScalar(-0.001))), 0, at(0, 0, 0));

		auto* ring = new btGImpactMeshShape(m_ringMesh.get());
		ring->setMargin(btScalar(0.01));
		ring->updateBound();
		shape(ring);
		for (int i = 0; i < 3; ++i) add(ring, 3, at(-4 + 0.2 * i, 0.6 + 1.1 * i, 0, 1.4 + 0.1 * i));

		btCollisionShape* box = shape(new btBoxShape(btVector3(btScalar(.4), btScalar(.3), btScalar(.5))));
		for (int i = 0; i < 6; ++i) add(box, 1, at(3 + 0.02 * i, 0.5 + 0.7 * i, 0.03 * i, 0.1 * i));
		auto* dumbbell = new btCompoundShape;
		dumbbell->addChildShape(at(0, 0, -.5), shape(new btSphereShape(btScalar(.3))));
		dumbbell->addChildShape(at(0, 0, .5), box);
		add(shape(dumbbell), 2, at(3, 6, 0));

		btRigidBody* post = add(box, 0, at(0, 3, 3));
		btRigidBody* door = add(box, 1, at(0.9, 3, 3));
		m_hinge = std::make_unique<btHingeConstraint>(
			*post, *door, btVector3(btScalar(.45), 0, 0), btVector3(btScalar(-.45), 0, 0), btVector3(0, 0, 1), btVector3(0, 0, 1));
		m_world.addConstraint(m_hinge.get());
	}
	~Game()
	{
		m_world.removeConstraint(m_hinge.get());
		for (auto& body : m_bodies) m_world.removeRigidBody(body.get());
	}

	btDiscreteDynamicsWorld& world() { return m_world; }
	void frame() { m_world.stepSimulation(btScalar(1.0 / 60), 4, btScalar(1.0 / 240)); }
	void print(int frame) const
	{
		for (size_t i = 0; i < m_bodies.size(); ++i)
		{
			const btVector3 p = m_bodies[i]->getWorldTransform().getOrigin(), v = m_bodies[i]->getLinearVelocity();
			std::printf("%d %zu %a %a %a %a %a %a\n", frame, i, double(p.x()), double(p.y()), double(p.z()), double(v.x()), double(v.y()),
				double(v.z()));
		}
	}
	/// Everybody is somewhere and nobody below the ground. How fast a pile moves depends on the processor's rounding.
	bool isSound() const
	{
		bool sound = true;
		for (const auto& body : m_bodies)
		{
			const btVector3 p = body->getWorldTransform().getOrigin();
			sound = sound && std::isfinite(double(p.length2())) && std::isfinite(double(body->getLinearVelocity().length2())) &&
				p.y() > btScalar(-0.1);
		}
		return sound;
	}

private:
	btCollisionShape* shape(btCollisionShape* made)
	{
		m_shapes.emplace_back(made);
		return made;
	}
	btRigidBody* add(btCollisionShape* of, double mass, const btTransform& pose)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) of->calculateLocalInertia(btScalar(mass), inertia);
		m_bodies.emplace_back(new btRigidBody(btScalar(mass), nullptr, of, inertia));
		m_bodies.back()->setWorldTransform(pose);
		m_world.addRigidBody(m_bodies.back().get());
		return m_bodies.back().get();
	}

	btDefaultCollisionConfiguration m_configuration;
	btCollisionDispatcher m_dispatcher{&m_configuration};
	btDbvtBroadphase m_broadphase;
	btSequentialImpulseConstraintSolver m_solver;
	btDiscreteDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
	btTriangleMesh m_ground;
	std::unique_ptr<btTriangleMesh> m_ringMesh{makeRing(0.6, 0.2)};
	std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
	std::unique_ptr<btHingeConstraint> m_hinge;
};

int main(int argc, char** argv)
{
	const bool attach = argc > 1 && std::strcmp(argv[1], "--attach") == 0;
	Game game;
#ifdef VOLUMETRIC
	btISTWorld ist(game.world());
	btISTTreeSource trees(ist.registration().registry());
	const auto rings = attach ? trees.attachGImpact(game.world()) : std::vector<btISTPendingAttachment>();
	if (trees.finish() != (attach ? 1 : 0)) return 2;
#else
	if (attach) return 2;
#endif
	std::clock_t ticks = 0;  // of the processor, whatever else runs
	const int frames = 360;
	for (int i = 0; i < frames; ++i)
	{
		const std::clock_t begin = std::clock();
		game.frame();
		ticks += std::clock() - begin;
		game.print(i);
	}
	std::fprintf(stderr, "%zu-byte scalars, %.1f us a frame\n", sizeof(btScalar), 1e6 * double(ticks) / CLOCKS_PER_SEC / frames);
	return game.isSound() ? 0 : 1;
}
