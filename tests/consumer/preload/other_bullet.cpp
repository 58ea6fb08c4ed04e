// SPDX-License-Identifier: Zlib
// A plug-in with a Bullet of its own inside: it has the names that the preload library stands before, and nothing else of Bullet's.
#include <cstdio>

class btDiscreteDynamicsWorld
{
public:
	virtual ~btDiscreteDynamicsWorld();
	virtual int stepSimulation(float seconds, int mostSteps, float part);
	virtual int stepSimulation(double seconds, int mostSteps, double part);
};

btDiscreteDynamicsWorld::~btDiscreteDynamicsWorld() { std::printf("gone\n"); }

int btDiscreteDynamicsWorld::stepSimulation(float seconds, int mostSteps, float part)
{
	std::printf("single %a %d %a\n", double(seconds), mostSteps, double(part));
	return 1;
}

int btDiscreteDynamicsWorld::stepSimulation(double seconds, int mostSteps, double part)
{
	std::printf("double %a %d %a\n", seconds, mostSteps, part);
	return 2;
}

namespace
{
/// A plug-in's own world calls the step of its base.
class Derived : public btDiscreteDynamicsWorld
{
public:
	int stepSimulation(float seconds, int mostSteps, float part) override
	{
		return btDiscreteDynamicsWorld::stepSimulation(seconds, mostSteps, part);
	}
	using btDiscreteDynamicsWorld::stepSimulation;
};
}  // namespace

extern "C" int play(int, char**)
{
	btDiscreteDynamicsWorld* const worlds[] = {new btDiscreteDynamicsWorld, new Derived};
	int steps = 0;
	for (btDiscreteDynamicsWorld* world : worlds)
	{
		for (int i = 0; i < 3; ++i) steps += world->stepSimulation(0.5f, 1, 0.25f) + world->stepSimulation(0.5, 1, 0.25);
		delete world;
	}
	return steps == 18 ? 0 : 1;
}
