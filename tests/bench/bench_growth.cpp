// SPDX-License-Identifier: Zlib
// Measures how cost grows with pairs of leaves, spheres, bodies, contacts and threads. Prints the exponent of the upper half of each
// row, the range in which the cost is linear, and the consequences for large scenes. Times are processor time of one thread, except in
// the rows of threads. Usage: bench_growth [--spheres MOST=10000] [--bodies MOST=1000] [--poses N=8] [--page FILE.html] [--csv FILE]
#include "BulletHapticForce/btBulletHapticForceCommon.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/scenes/Pages/HtmlReport.h"
#include "tests/bench/bodies/BenchPoses.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

using namespace ist;

namespace
{
constexpr double kRing = 0.5, kTube = 0.2;

struct Options
{
	int64_t spheres = 10000;
	int bodies = 1000, poses = 8;
	std::string page, csv;
};

double processor()
{
	timespec t;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
	return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// The numbers 1 and 3 times each power of ten.
std::vector<int64_t> upTo(int64_t most, int64_t first)
{
	std::vector<int64_t> numbers;
	for (int64_t ten = first; ten <= most; ten *= 10)
		for (const int64_t n : {ten, 3 * ten})
			if (n <= most) numbers.push_back(n);
	return numbers;
}

double median(std::vector<double> v)
{
	std::nth_element(v.begin(), v.begin() + long(v.size() / 2), v.end());
	return v[v.size() / 2];
}

/// Cost in microseconds, as a function of a number.
struct Row
{
	std::string name, unit;
	std::vector<double> n, cost;

	void add(double x, double y)
	{
		n.push_back(x);
		cost.push_back(y);
		std::printf("  %-34s %10.4g %-14s %12.4g us %12.4g us each\n", name.c_str(), x, unit.c_str(), y, y / x);
		std::fflush(stdout);
	}
	/// Exponent of the upper half of the row, by least squares of logarithms.
	double exponent() const
	{
		double sx = 0, sy = 0, sxx = 0, sxy = 0, count = 0;
		for (size_t i = n.size() / 2 > 0 && n.size() > 3 ? n.size() / 2 - 1 : 0; i < n.size(); ++i, ++count)
		{
			const double x = std::log(n[i]), y = std::log(cost[i]);
			sx += x, sy += y, sxx += x * x, sxy += x * y;
		}
		return (count * sxy - sx * sy) / (count * sxx - sx * sx);
	}
	double each() const { return cost.back() / n.back(); }
	/// Smallest number from which on the unit cost is within 25 % of its minimum; not a number if it never stays there.
	double linearFrom() const { return edge(true); }
	/// First number beyond the minimum at which the unit cost is 25 % above it; not a number if there is none.
	double linearUpTo() const { return edge(false); }

private:
	double edge(bool from) const
	{
		size_t best = 0;
		for (size_t i = 0; i < n.size(); ++i)
			if (cost[i] / n[i] < cost[best] / n[best]) best = i;
		const double most = 1.25 * cost[best] / n[best];
		if (from)
			for (size_t i = best + 1; i-- > 0;)
				if (i == 0 || cost[i - 1] / n[i - 1] > most) return n[i];
		for (size_t i = best; i < n.size(); ++i)
			if (cost[i] / n[i] > most) return n[i];
		return std::nan("");
	}
};

InnerSphereTree torusTree(int64_t spheres)
{
	Mesh mesh = makeTorusMesh(kRing, kTube, 48, 24);
	for (Vec3& p : mesh.vertices) p = {p.x, -p.z, p.y};  // the body lies flat
	BuildOptions build;
	build.maxSpheres = spheres;
	build.threads = 1;
	Result<InnerSphereTree> tree = buildTree(mesh, build);
	if (!tree) std::printf("%s\n", tree.error().message.c_str()), std::exit(1);
	return std::move(tree).value();
}

struct QueryTime
{
	double pairs = 0, microseconds = 0;
};

/// Medians over poses. Each is the smallest of five rounds through all poses, so that no pose runs twice in a row.
QueryTime timeQueries(const InnerSphereTree& A, const std::vector<Pose>& poses, QueryWorkspace& workspace)
{
	std::vector<double> least(poses.size(), 1e9), pairs(poses.size());
	for (int round = 0; round < 5; ++round)
		for (size_t i = 0; i < poses.size(); ++i)
		{
			const double begin = processor();
			pairs[i] = double(queryOverlap(A, A, poses[i], workspace).total.pairs);
			least[i] = std::min(least[i], 1e6 * (processor() - begin));
		}
	return {median(pairs), median(least)};
}

/// Tori that lie on a plane in columns.
class Columns
{
public:
	Columns(const std::shared_ptr<const InnerSphereTree>& tree, int count, int height, const btISTContactCache& contactCache)
		: m_attachment(m_world.attach(&m_shape, tree).value())
	{
		if (m_world.setContactCache(contactCache)) std::exit(1);
		m_world.contacts().measureQueryTime(true);
		add(&m_plane, 0, {});
		const int columns = (count + height - 1) / height, side = int(std::ceil(std::sqrt(columns)));
		for (int i = 0; i < count; ++i)
		{
			const int column = i / height, layer = i % height;
			add(&m_shape, 1, {1.6 * (column % side), kTube + 2 * kTube * layer - 0.0005 * (layer + 1), 1.6 * (column / side)});
			if (m_world.materials().set(m_bodies.back().get(), {1e5, -1})) std::exit(1);
		}
	}
	~Columns()
	{
		for (auto& b : m_bodies) m_world.bullet().removeRigidBody(b.get());
	}
	struct Cost
	{
		double step = 0, query = 0, contacts = 0;
	};
	/// Medians over the steps after the first ones [us].
	Cost run(int first, int steps)
	{
		std::vector<double> step, query;
		for (int i = 0; i < first + steps; ++i)
		{
			m_world.contacts().resetQueryTime();
			const double begin = processor();
			m_world.step(1.0 / 240);
			if (i < first) continue;
			step.push_back(1e6 * (processor() - begin));
			query.push_back(1e6 * m_world.contacts().querySeconds());
		}
		Cost cost{median(step), median(query), 0};
		for (const btISTContact* c : m_world.contacts().contacts()) cost.contacts += c->patchCount > 0;
		return cost;
	}

private:
	void add(btCollisionShape* shape, double mass, const Vec3& p)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
		m_bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape, inertia));
		btRigidBody* body = m_bodies.back().get();
		body->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z))));
		body->setInterpolationWorldTransform(body->getWorldTransform());
		m_world.bullet().addRigidBody(body);
		body->setActivationState(DISABLE_DEACTIVATION);
	}

	btISTWorld m_world;
	btBoxShape m_shape{btVector3(btScalar(kRing + kTube), btScalar(kTube), btScalar(kRing + kTube))};
	btStaticPlaneShape m_plane{btVector3(0, 1, 0), 0};
	btISTAttachment m_attachment;
	std::vector<std::unique_ptr<btRigidBody>> m_bodies;
};

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Wall time per query of one tree by this number of threads, each with its own workspace.
double threadedMicroseconds(const InnerSphereTree& tree, const std::vector<Pose>& poses, int threads)
{
	constexpr int kRounds = 40;
	double least = 1e9;
	for (int repeat = 0; repeat < 3; ++repeat)
	{
		std::vector<std::thread> pool;
		const double begin = now();
		for (int t = 0; t < threads; ++t)
			pool.emplace_back([&] {
				QueryWorkspace workspace;
				for (int round = 0; round < kRounds; ++round)
					for (const Pose& X : poses) queryOverlap(tree, tree, X, workspace);
			});
		for (std::thread& thread : pool) thread.join();
		least = std::min(least, 1e6 * (now() - begin) / (double(kRounds) * double(poses.size()) * threads));
	}
	return least;
}

struct Asset
{
	double buildSeconds = 0, megabytes = 0;
};

std::vector<Row> ofQueries(const Options& o, Asset& asset, std::shared_ptr<const InnerSphereTree>& small)
{
	Row pairs{"query over its pairs", "leaf pairs", {}, {}}, spheres{"query at 1 % over the spheres", "spheres", {}, {}},
		build{"build over the spheres", "spheres", {}, {}}, threads{"wall time a query, threads at once", "threads", {}, {}};
	QueryWorkspace workspace;
	const std::vector<int64_t> numbers = upTo(o.spheres, 100);
	for (const int64_t n : numbers)
	{
		const double begin = processor();
		const InnerSphereTree tree = torusTree(n);
		asset.buildSeconds = processor() - begin;
		build.add(double(n), 1e6 * asset.buildSeconds);
		const std::vector<Pose> poses = bench::posesAtOverlap(tree, tree, 0.01, o.poses);
		spheres.add(double(n), timeQueries(tree, poses, workspace).microseconds);
		if (n >= 1000 && !small) small = std::make_shared<const InnerSphereTree>(tree);
		if (n != numbers.back()) continue;
		for (const double overlap : {1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3})
		{
			const QueryTime t = timeQueries(tree, bench::posesAtOverlap(tree, tree, overlap, o.poses), workspace);
			if (t.pairs > 0) pairs.add(t.pairs, t.microseconds);
		}
		for (int count = 1; count <= int(std::thread::hardware_concurrency()); count *= 2)
			threads.add(count, threadedMicroseconds(tree, poses, count));
		const std::string file =
			(std::filesystem::temp_directory_path() / ("bench_growth-" + std::to_string(::getpid()) + ".ist")).string();
		if (const auto bytes = saveAsset(tree, file)) asset.megabytes = 1e-6 * double(bytes.value());
		std::filesystem::remove(file);
	}
	return {pairs, spheres, build, threads};
}

std::vector<Row> ofWorlds(const Options& o, const std::shared_ptr<const InnerSphereTree>& tree)
{
	Row apart{"step, bodies apart, all queried", "bodies", {}, {}}, kept{"step, bodies apart, contact cache 5 %", "bodies", {}, {}},
		queries{"queries of these, all queried", "bodies", {}, {}}, cachedQueries{"queries of these, contact cache 5 %", "bodies", {}, {}},
		piles{"step, stacks of ten, contact cache 5 %", "contacts", {}, {}},
		column{"step, one stack, contact cache 5 %", "contacts", {}, {}};
	const auto rounds = [](int bodies) { return std::max(12, 2000 / bodies); };
	for (const int64_t count : upTo(o.bodies, 10))
	{
		const int n = int(count);
		const Columns::Cost all = Columns(tree, n, 1, {false, 0}).run(30, rounds(n)),
							less = Columns(tree, n, 1, {true, 0.05}).run(30, rounds(n));
		apart.add(n, all.step);
		kept.add(n, less.step);
		queries.add(n, all.query);
		cachedQueries.add(n, less.query);
		const Columns::Cost pile = Columns(tree, n, 10, {true, 0.05}).run(30, rounds(n));
		piles.add(pile.contacts, pile.step);
	}
	for (const int height : {2, 5, 10, 20, 40, 60, 80, 120})
	{
		const Columns::Cost cost = Columns(tree, height, height, {true, 0.05}).run(10, 40);
		column.add(cost.contacts, cost.step);
	}
	return {apart, kept, queries, cachedQueries, piles, column};
}

std::string shown(double value) { return std::isfinite(value) ? scenes::formatNumber(value, 3) : "-"; }

void print(const std::vector<Row>& rows)
{
	std::printf(
		"\n| cost of | grows with | exponent | one costs, at the end [us] | linear from | no longer from |\n|---|---|---|---|---|---|\n");
	for (const Row& r : rows)
		std::printf("| %s | %s | %.2f | %.3g at %.4g | %s | %s |\n", r.name.c_str(), r.unit.c_str(), r.exponent(), r.each(), r.n.back(),
			shown(r.linearFrom()).c_str(), shown(r.linearUpTo()).c_str());
}

void onPaper(const std::vector<Row>& worlds, const Asset& asset, int64_t spheres)
{
	const double asked = worlds[0].each(), kept = worlds[1].each();
	std::printf("\n10,000 bodies that lie apart: %.3g ms a step when all are queried, %.3g ms with the contact cache, of one thread; "
				"sleepers cost no query.\n",
		10 * asked, 10 * kept);
	std::printf("100,000 assets of %lld spheres: %.3g GB on disk, %.3g hours of one thread to build.\n", static_cast<long long>(spheres),
		100 * asset.megabytes, 1e5 * asset.buildSeconds / 3600);
}

scenes::HtmlReport pageOf(const std::vector<Row>& rows)
{
	scenes::HtmlReport page("How cost grows");
	page.paragraph(
		"Processor time; both axes are logarithms to the base of ten, so that a straight line is a power law and its slope the exponent.");
	std::vector<std::vector<std::string>> table;
	for (const Row& r : rows)
		table.push_back({r.name, scenes::formatNumber(r.exponent(), 3), scenes::formatNumber(r.each(), 3), shown(r.linearFrom()),
			shown(r.linearUpTo())});
	page.table({"cost of", "exponent", "one costs at the end [us]", "linear from", "no longer from"}, table);
	for (const Row& r : rows)
	{
		scenes::Chart chart{r.name, "log10 of " + r.unit, "log10 of the cost [us]",
			{{"measured", {}, {}, {}, true}, {"linear, through the last", {}, {}, {}, false}}};
		for (size_t i = 0; i < r.n.size(); ++i)
		{
			for (scenes::ChartSeries& s : chart.series) s.x.push_back(std::log10(r.n[i]));
			chart.series[0].y.push_back(std::log10(r.cost[i]));
			chart.series[1].y.push_back(std::log10(r.each() * r.n[i]));
		}
		page.chart(chart);
	}
	return page;
}

Options parse(int argc, char** argv)
{
	Options o;
	for (int i = 1; i + 1 < argc; i += 2)
	{
		const std::string key = argv[i];
		if (key == "--spheres") o.spheres = std::max(1000L, std::atol(argv[i + 1]));
		if (key == "--bodies") o.bodies = std::max(10, std::atoi(argv[i + 1]));
		if (key == "--poses") o.poses = std::max(1, std::atoi(argv[i + 1]));
		if (key == "--page") o.page = argv[i + 1];
		if (key == "--csv") o.csv = argv[i + 1];
	}
	return o;
}
}  // namespace

int main(int argc, char** argv)
{
	const Options options = parse(argc, argv);
	Asset asset;
	std::shared_ptr<const InnerSphereTree> small;
	std::vector<Row> rows = ofQueries(options, asset, small);
	const std::vector<Row> worlds = ofWorlds(options, small);
	rows.insert(rows.end(), worlds.begin(), worlds.end());
	print(rows);
	onPaper(worlds, asset, int64_t(rows[1].n.back()));
	if (!options.page.empty() && !pageOf(rows).write(options.page)) return std::printf("cannot write %s\n", options.page.c_str()), 1;
	if (options.csv.empty()) return 0;
	std::FILE* csv = std::fopen(options.csv.c_str(), "w");
	if (!csv) return std::printf("cannot write %s\n", options.csv.c_str()), 1;
	std::fprintf(csv, "cost,grows_with,n,microseconds\n");
	for (const Row& r : rows)
		for (size_t i = 0; i < r.n.size(); ++i) std::fprintf(csv, "%s,%s,%g,%g\n", r.name.c_str(), r.unit.c_str(), r.n[i], r.cost[i]);
	return std::fclose(csv) == 0 ? 0 : 1;
}
