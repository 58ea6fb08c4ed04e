// SPDX-License-Identifier: Zlib
// To be preloaded into any program that steps a btDiscreteDynamicsWorld: writes the pose of every object after each frame to the file TRACE, to the last bit, and in the
// end the processor time of the frames' steps to stderr. After TRACE_FRAMES of them, if that is said, it counts no more and asks the program to end.
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <dlfcn.h>
#include <vector>

namespace
{
struct Trace
{
	std::FILE* file = std::fopen(std::getenv("TRACE") ? std::getenv("TRACE") : "/dev/null", "w");
	const size_t most = std::getenv("TRACE_FRAMES") ? size_t(std::atol(std::getenv("TRACE_FRAMES"))) : size_t(-1);
	std::vector<double> milliseconds;
	bool isFull() const { return milliseconds.size() >= most; }
	~Trace()
	{
		if (file) std::fclose(file);
		double sum = 0;
		for (const double time : milliseconds) sum += time;
		std::sort(milliseconds.begin(), milliseconds.end());
		if (!milliseconds.empty()) std::fprintf(stderr, "frames %zu, mean %.3f ms, median %.3f ms\n", milliseconds.size(), sum / milliseconds.size(), milliseconds[milliseconds.size() / 2]);
	}
};

double now()
{
	timespec time;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
	return 1e3 * double(time.tv_sec) + 1e-6 * double(time.tv_nsec);
}
}  // namespace

int btDiscreteDynamicsWorld::stepSimulation(btScalar seconds, int most, btScalar fixed)
{
	using Step = int (*)(btDiscreteDynamicsWorld*, btScalar, int, btScalar);
	static const auto bullets = reinterpret_cast<Step>(dlsym(RTLD_NEXT, sizeof(btScalar) == 4 ? "_ZN23btDiscreteDynamicsWorld14stepSimulationEfif" : "_ZN23btDiscreteDynamicsWorld14stepSimulationEdid"));
	static Trace trace;
	const double begin = now();
	const int steps = bullets(this, seconds, most, fixed);
	if (trace.isFull()) return steps;
	trace.milliseconds.push_back(now() - begin);
	for (int i = 0; trace.file && i < getNumCollisionObjects(); ++i)
	{
		const btTransform& X = getCollisionObjectArray()[i]->getWorldTransform();
		for (int row = 0; row < 3; ++row)
			std::fprintf(trace.file, "%a %a %a %a ", double(X.getBasis()[row][0]), double(X.getBasis()[row][1]), double(X.getBasis()[row][2]), double(X.getOrigin()[row]));
		std::fputc('\n', trace.file);
	}
	if (trace.isFull()) std::raise(SIGTERM);
	return steps;
}
