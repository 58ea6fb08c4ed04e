// SPDX-License-Identifier: Zlib
#include "tests/bench/peers/ParetoSweep.h"

#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"
#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Build/TreeCache.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "BulletISTCollision/Core/Tuning/StableTimeStep.h"
#include "TestSupport/SceneFiles/AssetCache.h"
#include "demos/scenes/Extremes/ForceAlongPath.h"
#include "tests/bench/bodies/BenchBodies.h"
#include "tests/bench/peers/PeerContacts.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

using namespace ist;

namespace bench
{
namespace
{
constexpr double kHeld = 0.95;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Processor time of all threads [s].
double processorTime() { return double(std::clock()) / CLOCKS_PER_SEC; }

double quantile(std::vector<double> values, double share)
{
	if (values.empty()) return 0;
	const auto at = values.begin() + ptrdiff_t(share * double(values.size() - 1) + 0.5);
	std::nth_element(values.begin(), at, values.end());
	return *at;
}

double treeBytes(const InnerSphereTree& tree)
{
	size_t sum = tree.law.memory() + tree.cells.memory() + tree.inner.memory() + tree.spheres.size() * sizeof(Sphere);
	for (const BallTree& level : tree.levels) sum += level.memory();
	return double(sum);
}

/// Builds the body, or loads it together with the time that building it took.
SweptBody makeBody(const std::string& name, int spheres, const std::string& folder)
{
	SweptBody body;
	BuildOptions options;
	options.surface = false;  // contact of leaves
	options.maxSpheres = spheres;
	const Mesh mesh = placed(meshNamed(name));
	const auto say = [](const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
	Result<scenes::CachedTree> tree = scenes::treeFromCache(mesh, options, folder, name, say);
	if (!tree) return say(name + ": " + tree.error().message), body;
	const std::string seconds = folder + "/" + name + "-" + std::to_string(treeKey(mesh, options)) + ".seconds";
	body.buildSeconds = tree.value().seconds;
	if (tree.value().loaded) std::ifstream(seconds) >> body.buildSeconds;
	else if (!folder.empty()) std::ofstream(seconds) << body.buildSeconds;
	body.tree = *tree.value().tree;
	// This is processor time, because both run on one thread.
	const double start = processorTime();
	body.tree.levels = buildLevels(body.tree.law);
	const double levels = processorTime();
	body.tree.calibration = measuredCalibration(body.tree);
	std::fprintf(stderr, "%s, %d spheres: levels in %.3f s, calibration in %.3f s of processor time\n", name.c_str(), spheres,
		levels - start, processorTime() - levels);
	body.bytes = treeBytes(body.tree);
	return body;
}

/// Answer of an estimator in one pose: for k = 1, with the torque about A's centre of mass.
struct Estimate
{
	double volume = 0, pairs = 0;
	Wrench wrench;
	Vec3 centroid;
};

Estimate estimateOf(const OverlapResult& result, const Vec3& origin)
{
	const OverlapIntegrals& total = result.total;
	Estimate e{total.volume, double(total.pairs), pressureWrench(total, {}), origin};
	if (total.volume > 0) e.centroid = origin + total.firstMoment / total.volume;
	return e;
}

using Estimator = std::function<Estimate(const Pose&)>;

/// The analytic field of a body that has a closed form, and its pose in the mesh's frame.
std::unique_ptr<AnalyticField> closedForm(const std::string& name)
{
	if (name == "box") return std::make_unique<BoxField>(Vec3{0.5, 0.35, 0.25});
	if (name == "ball") return std::make_unique<CapsuleField>(0.5, 0);
	return nullptr;
}

/// Estimator of a library that returns contacts and no force: the sum of depth times normal.
Estimator ofPeer(Peer& peer)
{
	return [&peer](const Pose& X) {
		const PeerAnswer answer = peer.ask(X);
		constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
		return Estimate{kNone, double(answer.contacts), {answer.push, {kNone, kNone, kNone}}, {kNone, kNone, kNone}};
	};
}

class PairSweep
{
public:
	PairSweep(const SweepSettings& settings, const std::string& nameA, const std::string& nameB, int spheres, const SweptBody& A,
		const SweptBody& B, const std::vector<TruePose>& poses)
		: m_settings(settings),
		  m_A(A.tree),
		  m_B(B.tree),
		  m_poses(poses),
		  m_nameB(nameB)
	{
		m_row.pair = nameA + "-" + nameB;
		m_row.spheres = spheres;
		m_row.buildSeconds = A.buildSeconds + B.buildSeconds;
		m_row.bytes = A.bytes + B.bytes;
		m_size = std::min(m_A.box.longestSide(), m_B.box.longestSide());
	}

	void run(Sweep& sweep)
	{
		measureDepths();
		for (int level = 0; level <= levelCount(m_A, m_B); ++level) measure("level " + std::to_string(level), fixedLevel(level), 1, sweep);
		for (const int budget : m_settings.budgets) measure("budget " + std::to_string(budget), budgeted(budget), 1, sweep);
		for (const double error : m_settings.errors)
		{
			measure("dial " + std::to_string(int(std::lround(100 * error))) + " %", dialled(error), 1, sweep);
			sweep.errorBounds.push_back(errorBoundOf(error));
		}
		measure("paper", paper(), gainOf(paper()), sweep);
		if (const std::unique_ptr<AnalyticField> field = closedForm(m_nameB)) measure("closed form", against(*field), 1, sweep);
	}
	/// Runs once for each pair of meshes, because peers have no spheres.
	void runPeers(const Mesh& A, const Mesh& B, Sweep& sweep)
	{
		measureDepths();
		m_row.spheres = 0;
		m_row.bytes = m_row.buildSeconds = std::numeric_limits<double>::quiet_NaN();
		for (const std::unique_ptr<Peer>& peer : makePeers(A, B))
		{
			measure(peer->name(), ofPeer(*peer), gainOf(ofPeer(*peer)), sweep);
		}
	}

private:
	QueryOptions plain() const
	{
		QueryOptions options;
		options.patches = false;
		return options;
	}
	Estimator fixedLevel(int level)
	{
		return [this, level](const Pose& X) {
			QueryOptions options = plain();
			options.level = level;
			return estimateOf(queryOverlap(m_A, m_B, X, m_workspace, options), m_A.origin);
		};
	}
	Estimator budgeted(int budget)
	{
		return [this, budget](const Pose& X) {
			QueryOptions options = plain();
			options.maxPairs = budget;
			return estimateOf(queryOverlap(m_A, m_B, X, m_workspace, options), m_A.origin);
		};
	}
	Estimator dialled(double error)
	{
		return [this, error](const Pose& X) {
			ForceTolerance accepted;
			accepted.error = error;
			return estimateOf(queryWithTolerance(m_A, m_B, X, m_workspace, accepted, plain()).overlap, m_A.origin);
		};
	}
	/// Equation (1) as printed, at rest: packed spheres, along the lines of the centres.
	Estimator paper()
	{
		return [this](const Pose& X) {
			QueryOptions options = plain();
			options.model = Model::Inner;
			const OverlapResult result = queryOverlap(m_A, m_B, X, m_workspace, options);
			Estimate e = estimateOf(result, m_A.origin);
			e.wrench = result.total.line;
			return e;
		};
	}
	Estimator against(const AnalyticField& field)
	{
		return [this, &field](const Pose& X) { return estimateOf(queryField(m_A, field, X * X_BF(), m_workspace, plain()), m_A.origin); };
	}
	/// Pose of a body's centre after `placed`.
	static Pose X_BF()
	{
		Pose X;
		X.translation = {0.3, -0.2, 0.5};
		return X;
	}
	/// Stiffness for a law that leaves it to experience: the one that fits these poses best.
	double gainOf(const Estimator& estimator) const
	{
		std::vector<double> gains;
		for (const TruePose& pose : m_poses)
			if (const double force = norm(estimator(pose.X_AB).wrench.force); force > 0)
				gains.push_back(norm(pose.truth.wrench().force) / force);
		return quantile(gains, 0.5);
	}
	/// Median depth of the overlap at each requested share.
	void measureDepths()
	{
		for (const double overlap : m_settings.truth.overlaps)
		{
			std::vector<double> depths;
			for (const TruePose& pose : m_poses)
			{
				const OverlapIntegrals total = queryOverlap(m_A, m_B, pose.X_AB, m_workspace, plain()).total;
				if (pose.overlap == overlap && total.volume > 0) depths.push_back(total.volume / norm(total.areaVector));
			}
			m_depths[overlap] = quantile(depths, 0.5) / (m_A.errorLength() + m_B.errorLength());
		}
	}

	void measure(const std::string& name, const Estimator& estimator, double gain, Sweep& sweep)
	{
		for (const double overlap : m_settings.truth.overlaps)
		{
			std::vector<const TruePose*> poses;
			for (const TruePose& pose : m_poses)
				if (pose.overlap == overlap) poses.push_back(&pose);
			if (poses.empty()) continue;
			m_row.estimator = name;
			m_row.overlap = overlap;
			m_row.poses = int(poses.size());
			m_row.depthOverGap = m_depths[overlap];
			judge(poses, estimator, gain);
			clock(poses, estimator);
			lead(poses, estimator, gain);
			sweep.rows.push_back(m_row);
		}
	}

	void judge(const std::vector<const TruePose*>& poses, const Estimator& estimator, double gain)
	{
		const double n = double(poses.size());
		std::vector<double> errors, angles, volumes;
		double size = 0, torque = 0, point = 0;
		m_row.pairs = m_row.volumeBias = m_row.volumeSpread = 0;
		for (const TruePose* pose : poses)
		{
			const Estimate e = estimator(pose->X_AB);
			const Wrench truth = pose->truth.wrench(), wrench = gain * e.wrench;
			const double force = norm(truth.force);
			volumes.push_back(e.volume / pose->truth.volume - 1);
			errors.push_back(norm(wrench.force - truth.force) / force);
			angles.push_back(180 / std::numbers::pi * std::atan2(norm(cross(wrench.force, truth.force)), dot(wrench.force, truth.force)));
			size += std::pow(norm(wrench.force) / force - 1, 2) / n;
			torque += squaredNorm(wrench.torque - truth.torque) / (force * force * m_size * m_size) / n;
			point += squaredNorm(e.centroid - pose->truth.centroid) / (m_size * m_size) / n;
			m_row.pairs += e.pairs / n;
			m_row.volumeBias += volumes.back() / n;
		}
		double squares = 0;
		for (double error : errors) squares += error * error / n;
		for (double v : volumes) m_row.volumeSpread += (v - m_row.volumeBias) * (v - m_row.volumeBias) / n;
		m_row.volumeSpread = std::sqrt(m_row.volumeSpread);
		m_row.force = std::sqrt(squares);
		m_row.force95 = quantile(errors, kHeld);
		m_row.forceSize = std::sqrt(size);
		m_row.direction = quantile(angles, 0.5);
		m_row.torque = std::sqrt(torque);
		m_row.point = std::sqrt(point);
	}

	/// Runs the poses in a new order each time, so that the branch predictor cannot learn them.
	void clock(std::vector<const TruePose*> poses, const Estimator& estimator)
	{
		std::mt19937 random(1);
		std::vector<double> times;
		for (int pass = 0; pass < m_settings.passes; ++pass)
		{
			std::shuffle(poses.begin(), poses.end(), random);
			for (const TruePose* pose : poses)
			{
				const double start = now();
				estimator(pose->X_AB);
				times.push_back(1e6 * (now() - start));
			}
		}
		m_row.p50 = quantile(times, 0.5);
		m_row.p99 = quantile(times, 0.99);
		m_row.p999 = quantile(times, 0.999);
	}

	/// Follows paths through the first of the poses.
	void lead(const std::vector<const TruePose*>& poses, const Estimator& estimator, double gain)
	{
		constexpr double kFar = 1000, kTick = 1e-3, kDamping = 5, kGravity = 9.81, kLoss = 0.05;
		const auto force = [&](const Pose& X) { return gain * estimator(X).wrench.force; };
		m_row.noise = m_row.loopWork = m_row.restDepth = m_row.inFloat = 0;
		m_row.implicitStep = m_row.explicitK = std::numeric_limits<double>::infinity();
		for (size_t i = 0; i < std::min(poses.size(), size_t(m_settings.paths)); ++i)
		{
			const TruePose& pose = *poses[i];
			const scenes::PathStart start{pose.X_AB, pose.truth.wrench().force, m_size};
			const scenes::PathQuality q = scenes::followPath(start, force);
			m_row.noise = std::max(m_row.noise, q.noise);
			m_row.loopWork = std::max(m_row.loopWork, q.loopWork);
			// A missing depth counts as the worst one.
			if (!(std::fabs(q.restDepth) <= std::fabs(m_row.restDepth))) m_row.restDepth = q.restDepth;
			m_row.inFloat = std::max(m_row.inFloat, scenes::changeInFloat(start, kFar, force));
			const double h = longestExplicitStep({q.stiffness, 1, 0});  // valid for k = 1
			m_row.explicitK = std::min(m_row.explicitK, h * h / (kTick * kTick));
			// With k = m g / |F| the body rests in this pose.
			m_row.implicitStep = std::min(
				m_row.implicitStep, longestStepForRestitution({q.stiffness * kGravity / norm(start.trueForce), 1, 0}, kLoss));
		}
		m_row.zWidth = kDamping / (0.5 * kTick + 1e-6 * m_row.p999);
	}

	ErrorBoundRow errorBoundOf(double error)
	{
		ErrorBoundRow row{m_row.pair, error, m_row.spheres, int(m_poses.size())};
		const double floor = forceFloor(m_A, m_B), n = double(m_poses.size());
		std::vector<double> pairs(size_t(levelCount(m_A, m_B)) + 1), within(pairs.size());
		std::vector<double> shares;
		double asked = 0, answered = 0;
		for (const TruePose& pose : m_poses)
		{
			const Vec3 truth = pose.truth.wrench().force;
			const double size = std::max(norm(truth), floor);
			ForceTolerance accepted;
			accepted.error = error;
			const BoundedOverlap answer = queryWithTolerance(m_A, m_B, pose.X_AB, m_workspace, accepted, plain());
			const double off = norm(pressureWrench(answer.overlap.total, {}).force - truth) / size;
			row.held += (off <= std::max(error, answer.errorBound)) / n;
			shares.push_back(off / answer.errorBound);
			if (answer.errorBound > 0 && shares.back() > row.worst / row.largestErrorBound)
				row.worst = off, row.largestErrorBound = answer.errorBound;
			row.kept += answer.kept / n;
			asked += double(answer.pairs);
			answered += double(answer.overlap.total.pairs);
			for (size_t level = 0; level < pairs.size(); ++level)
			{
				const Estimate e = fixedLevel(int(level))(pose.X_AB);
				pairs[level] += e.pairs;
				within[level] += norm(e.wrench.force - truth) <= error * size;
			}
		}
		row.ofErrorBound = quantile(shares, 0.5);
		row.ofLeaves = answered / pairs[0];
		double cheapest = 0;
		for (size_t level = 0; level < pairs.size(); ++level)
			if (within[level] >= kHeld * n) cheapest = pairs[level];
		row.ofFixed = cheapest > 0 ? asked / cheapest : 0;
		return row;
	}

	const SweepSettings& m_settings;
	const InnerSphereTree& m_A;
	const InnerSphereTree& m_B;
	const std::vector<TruePose>& m_poses;
	std::string m_nameB;
	QueryWorkspace m_workspace;
	ParetoRow m_row;
	std::map<double, double> m_depths;  ///< median depth by overlap
	double m_size = 1;
};

std::vector<int> numbersOfSpheres(const SweepSettings& settings, size_t pair)
{
	std::vector<int> numbers = settings.spheres;
	if (pair == 0) numbers.insert(numbers.end(), settings.manySpheres.begin(), settings.manySpheres.end());
	return numbers;
}
}  // namespace

bool runSweep(const SweepSettings& settings, Sweep& sweep, const std::function<bool()>& keep)
{
	std::map<std::pair<std::string, int>, SweptBody> bodies;
	for (size_t p = 0; p < settings.pairs.size(); ++p)
	{
		const auto& [a, b] = settings.pairs[p];
		if (placed(meshNamed(a)).triangles.empty() || placed(meshNamed(b)).triangles.empty())
		{
			std::fprintf(stderr, "%s-%s: skipped; apt-get install glmark2-data\n", a.c_str(), b.c_str());
			continue;
		}
		const double start = processorTime();
		const std::vector<TruePose> poses = truePoses(a, b, settings.truth, settings.folder);
		std::fprintf(stderr, "%s-%s: %zu poses integrated in %.1f s of processor time\n", a.c_str(), b.c_str(), poses.size(),
			processorTime() - start);
		bool peersAsked = !settings.peers;
		for (const int spheres : numbersOfSpheres(settings, p))
		{
			for (const std::string& name : {a, b})
				if (!bodies.count({name, spheres})) bodies[{name, spheres}] = makeBody(name, spheres, settings.folder);
			const SweptBody &A = bodies[{a, spheres}], &B = bodies[{b, spheres}];
			if (A.tree.law.empty() || B.tree.law.empty()) continue;
			PairSweep pair(settings, a, b, spheres, A, B, poses);
			pair.run(sweep);
			if (!std::exchange(peersAsked, true)) pair.runPeers(placed(meshNamed(a)), placed(meshNamed(b)), sweep);
			std::fprintf(stderr, "%s-%s: %d spheres, %.1f s of processor time; pair %zu of %zu\n", a.c_str(), b.c_str(), spheres,
				processorTime() - start, p + 1, settings.pairs.size());
			if (!keep()) return false;
		}
	}
	return true;
}
}  // namespace bench
