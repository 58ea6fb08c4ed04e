// SPDX-License-Identifier: Zlib
// To be preloaded into any program that steps a btDiscreteDynamicsWorld: writes the pose of every object after each frame to the file
// TRACE, to the last bit, and in the end to stderr the processor time of the frames' steps and how wild it was: how fast any body moved at
// most, from frame to frame, where they all were, and how far apart neighbours are that were added one after the other, as the links of a
// chain. After TRACE_FRAMES of them, if that is said, it counts no more and asks the program to end.
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <dlfcn.h>
#include <unordered_map>
#include <vector>

namespace
{
/// What is not a number stays.
void enlarge(double& largest, double value)
{
	if (value > largest || value != value) largest = value;
}

/// [m/s] between two poses: that of the fastest of six points around the bounding sphere, which spin moves, too.
double speed(const btTransform& before, const btTransform& after, const btCollisionShape& shape, double seconds)
{
	btVector3 centre;
	btScalar radius = 0;
	shape.getBoundingSphere(centre, radius);
	double fastest = 0;
	for (int i = 0; i < 6; ++i)
	{
		btVector3 point = centre;
		point[i / 2] += i % 2 ? radius : -radius;
		enlarge(fastest, (after * point - before * point).length() / seconds);
	}
	return fastest;
}

class Motion
{
public:
	void add(const btDiscreteDynamicsWorld& world, double seconds)
	{
		std::unordered_map<const btCollisionObject*, btTransform> now;
		double fastest = 0;
		for (int i = 0; i < world.getNumCollisionObjects(); ++i)
		{
			const btCollisionObject* object = world.getCollisionObjectArray()[i];
			if (object->isStaticOrKinematicObject()) continue;  // contact cannot move it
			const btTransform& pose = now[object] = object->getWorldTransform();
			m_lower.setMin(pose.getOrigin());
			m_upper.setMax(pose.getOrigin());
			const auto before = m_poses.find(object);
			if (before != m_poses.end() && seconds > 0)
				enlarge(fastest, speed(before->second, pose, *object->getCollisionShape(), seconds));
		}
		m_apart = largestGap(world);
		m_poses.swap(now);
		m_frames.push_back({seconds, fastest});
	}
	void print() const
	{
		double ever = 0, last = 0, seconds = 0;
		for (size_t i = m_frames.size(); i-- > 0; seconds += m_frames[i].seconds)
		{
			enlarge(ever, m_frames[i].fastest);
			if (seconds < 1) last = ever;
		}
		std::fprintf(stderr,
			"fastest %.2f m/s, in the last second %.2f m/s; neighbours %.2f m apart; centres from (%.1f %.1f %.1f) to (%.1f %.1f %.1f) m\n",
			ever, last, m_apart, double(m_lower.x()), double(m_lower.y()), double(m_lower.z()), double(m_upper.x()), double(m_upper.y()),
			double(m_upper.z()));
	}

private:
	/// Between the centres of two objects that follow each other; planes have none.
	static double largestGap(const btDiscreteDynamicsWorld& world)
	{
		double largest = 0;
		for (int i = 1; i < world.getNumCollisionObjects(); ++i)
		{
			const btCollisionObject *a = world.getCollisionObjectArray()[i - 1], *b = world.getCollisionObjectArray()[i];
			if (a->getCollisionShape()->isInfinite() || b->getCollisionShape()->isInfinite()) continue;
			enlarge(largest, a->getWorldTransform().getOrigin().distance(b->getWorldTransform().getOrigin()));
		}
		return largest;
	}

	struct Frame
	{
		double seconds, fastest;
	};
	std::vector<Frame> m_frames;
	double m_apart = 0;                                                 // in the end
	std::unordered_map<const btCollisionObject*, btTransform> m_poses;  // after the frame before
	btVector3 m_lower{BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT}, m_upper{-BT_LARGE_FLOAT, -BT_LARGE_FLOAT, -BT_LARGE_FLOAT};
};

struct Trace
{
	std::FILE* file = std::fopen(std::getenv("TRACE") ? std::getenv("TRACE") : "/dev/null", "w");
	const size_t most = std::getenv("TRACE_FRAMES") ? size_t(std::atol(std::getenv("TRACE_FRAMES"))) : size_t(-1);
	std::vector<double> milliseconds;
	Motion motion;
	bool isFull() const { return milliseconds.size() >= most; }
	~Trace()
	{
		if (file) std::fclose(file);
		double sum = 0;
		for (const double time : milliseconds) sum += time;
		std::sort(milliseconds.begin(), milliseconds.end());
		if (milliseconds.empty()) return;
		std::fprintf(stderr, "frames %zu, mean %.3f ms, median %.3f ms\n", milliseconds.size(), sum / milliseconds.size(),
			milliseconds[milliseconds.size() / 2]);
		motion.print();
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
	static const auto bullets = reinterpret_cast<Step>(dlsym(RTLD_NEXT,
		sizeof(btScalar) == 4 ? "_ZN23btDiscreteDynamicsWorld14stepSimulationEfif" : "_ZN23btDiscreteDynamicsWorld14stepSimulationEdid"));
	static Trace trace;
	const double begin = now();
	const int steps = bullets(this, seconds, most, fixed);
	if (trace.isFull()) return steps;
	trace.milliseconds.push_back(now() - begin);
	trace.motion.add(*this, most > 0 ? std::min(steps, most) * double(fixed) : double(seconds));
	for (int i = 0; trace.file && i < getNumCollisionObjects(); ++i)
	{
		const btTransform& X = getCollisionObjectArray()[i]->getWorldTransform();
		for (int row = 0; row < 3; ++row)
			std::fprintf(trace.file, "%a %a %a %a ", double(X.getBasis()[row][0]), double(X.getBasis()[row][1]),
				double(X.getBasis()[row][2]), double(X.getOrigin()[row]));
		std::fputc('\n', trace.file);
	}
	if (trace.isFull()) std::raise(SIGTERM);
	return steps;
}
