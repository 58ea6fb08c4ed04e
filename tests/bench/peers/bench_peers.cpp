// SPDX-License-Identifier: Zlib
// Compares other libraries and this one on the same closed meshes in the same poses: with the angle to the exact gradient of the
// overlap, and a page. Peers take the triangles as they are, without margins. Their contacts are summed up as depth times normal.
// Usage: bench_peers [--poses N=10] [--steps N=200] [--spheres N=10000] [--report PAGE.html] [PAIR]... (bunny-bunny, bunny-probe,
// torus-torus)
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Distance/MeshDistance.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/ProximityQuery.h"
#include "demos/scenes/Pages/HtmlReport.h"
#include "tests/bench/bodies/BenchBodies.h"
#include "tests/bench/bodies/BenchPoses.h"
#include "tests/bench/peers/PeerContacts.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

using namespace ist;

namespace
{
struct Settings
{
	int poses = 10, steps = 200, spheres = 10000;
	std::string report;
	std::vector<std::string> pairs;
};

struct Body
{
	Mesh mesh;
	MeshDistance distance;
	InnerSphereTree tree;
};

Body bodyOf(const Mesh& mesh, int spheres)
{
	BuildOptions options;
	options.surface = false;  // contact of leaves
	options.maxSpheres = spheres;
	Result<InnerSphereTree> tree = buildTree(mesh, options);
	if (!tree) std::fprintf(stderr, "bench_peers: %s\n", tree.error().message.c_str()), std::exit(1);
	return {mesh, MeshDistance(mesh), std::move(tree).value()};
}

/// This library as a peer: the gradient of the volume, or the force of its law.
class Own : public bench::Peer
{
public:
	Own(const InnerSphereTree& A, const InnerSphereTree& B, bool force) : m_A(A), m_B(B), m_force(force) {}
	std::string name() const override { return m_force ? "this library, force" : "this library, area_vector"; }
	bench::PeerAnswer ask(const Pose& X) override
	{
		QueryOptions options;
		options.patches = options.stiffness = false;
		options.requireInnerOverlap = true;
		const OverlapResult r = queryOverlap(m_A, m_B, X, m_workspace, options);
		const Vec3 push = m_force ? pressureWrench(r.total, {}).force : r.total.areaVector;
		return {push, int(r.total.volume > 0 ? r.total.pairs : 0)};
	}

private:
	const InnerSphereTree &m_A, &m_B;
	bool m_force;
	QueryWorkspace m_workspace;
};

/// Part of a triangle's area vector inside B. Triangles that cross the surface are quartered.
Vec3 areaInside(const MeshDistance& B, const Pose& X_BA, const Vec3& a, const Vec3& b, const Vec3& c, int depth)
{
	const Vec3 middle = (a + b + c) / 3.0, area = cross(b - a, c - a) * 0.5;
	const double reach = std::max({distance(a, middle), distance(b, middle), distance(c, middle)});
	const double signedDistance = B.signedDistance(X_BA * middle);
	if (signedDistance >= reach) return {};
	if (signedDistance <= -reach || depth == 0) return signedDistance < 0 ? area : Vec3{};
	const Vec3 ab = (a + b) * 0.5, bc = (b + c) * 0.5, ca = (c + a) * 0.5;
	return areaInside(B, X_BA, a, ab, ca, depth - 1) + areaInside(B, X_BA, ab, b, bc, depth - 1) +
		areaInside(B, X_BA, ca, bc, c, depth - 1) + areaInside(B, X_BA, ab, bc, ca, depth - 1);
}

struct Truth
{
	Vec3 push;  ///< negative gradient of the overlap by A's position: A's surface inside B, reversed [m^2]
	bool meets = false;
};

/// Computed from the triangles and the side of the other mesh on which they lie. It shares nothing with packing and queries.
Truth truthOf(const Body& A, const Body& B, const Pose& X)
{
	const Pose back{transpose(X.rotation), transpose(X.rotation) * (X.translation * -1.0)};
	Box box = bounds(B.mesh);
	const Vec3 middle = (box.lower + box.upper) * 0.5;
	const double reach = 0.5 * norm(box.upper - box.lower);
	Truth truth;
	for (const auto& t : A.mesh.triangles)
	{
		const Vec3 &a = A.mesh.vertices[t[0]], &b = A.mesh.vertices[t[1]], &c = A.mesh.vertices[t[2]];
		const double size = std::max(distance(a, b), distance(a, c));
		if (distance(back * a, middle) > reach + size) continue;
		const Vec3 part = areaInside(B.distance, back, a, b, c, 3);
		truth.meets = truth.meets || squaredNorm(part) > 0;
		truth.push -= part;
	}
	truth.meets = truth.meets || A.distance.contains(X * B.mesh.vertices[0]) || B.distance.contains(back * A.mesh.vertices[0]);
	return truth;
}

double angleBetween(const Vec3& a, const Vec3& b)
{
	const double product = norm(a) * norm(b);
	return product > 0 ? std::acos(std::clamp(dot(a, b) / product, -1.0, 1.0)) * 57.29577951308232 : 180;
}

double quantile(std::vector<double> values, double q)
{
	if (values.empty()) return NAN;
	std::sort(values.begin(), values.end());
	return values[std::min(values.size() - 1, size_t(q * double(values.size())))];
}

double timed(bench::Peer& peer, const Pose& X, bench::PeerAnswer& answer)
{
	double least = 1e300;
	for (int visit = 0; visit < 3; ++visit)
	{
		const auto start = std::chrono::steady_clock::now();
		answer = peer.ask(X);
		least = std::min(least, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
	}
	return least;
}

struct Page
{
	scenes::HtmlReport html{"Overlap queries side by side"};
	void table(const std::string& title, const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows)
	{
		html.heading(title);
		html.table(head, rows);
		std::printf("\n%s\n", title.c_str());
		for (size_t c = 0; c < head.size(); ++c) std::printf(c == 0 ? "%-36s" : " | %s", head[c].c_str());
		for (const auto& row : rows)
		{
			std::printf("\n");
			for (size_t c = 0; c < row.size(); ++c) std::printf(c == 0 ? "%-36s" : " | %s", row[c].c_str());
		}
		std::printf("\n");
		std::fflush(stdout);
	}
};

using Peers = std::vector<std::unique_ptr<bench::Peer>>;

void comparePoses(const std::string& name, const Body& A, const Body& B, Peers& peers, int count, Page& page)
{
	const std::vector<double> overlaps{0.001, 0.01, 0.1, 0.5};
	std::vector<std::vector<std::string>> times, angles;
	scenes::Chart chart{name + ", time of a query", "overlap [% of the smaller body]", "time [us]", {}};
	std::vector<std::vector<Pose>> poses;
	std::vector<std::vector<Truth>> truths;
	for (const double overlap : overlaps)
	{
		poses.push_back(bench::posesAtOverlap(A.tree, B.tree, overlap, count));
		truths.emplace_back();
		for (const Pose& X : poses.back()) truths.back().push_back(truthOf(A, B, X));
	}
	for (auto& peer : peers)
	{
		times.push_back({peer->name()});
		angles.push_back({peer->name()});
		scenes::ChartSeries series{peer->name(), {}, {}, {}, false};
		for (size_t o = 0; o < overlaps.size(); ++o)
		{
			std::vector<double> us, degrees, contacts;
			int missed = 0;
			for (size_t i = 0; i < poses[o].size(); ++i)
			{
				bench::PeerAnswer answer;
				us.push_back(timed(*peer, poses[o][i], answer));
				contacts.push_back(answer.contacts);
				if (answer.contacts == 0) ++missed;
				else degrees.push_back(angleBetween(answer.push, truths[o][i].push));
			}
			times.back().push_back(scenes::formatNumber(quantile(us, 0.5), 3) + " (" + scenes::formatNumber(quantile(us, 1), 3) + ")");
			const std::string missing = missed > 0 ? ", " + std::to_string(missed) + " missed" : "";
			angles.back().push_back(
				scenes::formatNumber(quantile(degrees, 0.5), 2) + " (" + scenes::formatNumber(quantile(degrees, 1), 2) + ")" + missing);
			series.x.push_back(100 * overlaps[o]);
			series.y.push_back(quantile(us, 0.5));
			if (o == 1) angles.back().push_back(scenes::formatNumber(quantile(contacts, 0.5), 4));
		}
		chart.series.push_back(series);
	}
	page.table(name + ": time, median (most) [us]", {"", "0.1 %", "1 %", "10 %", "50 %"}, times);
	page.html.chart(chart);
	page.table(name + ": angle to the exact gradient, median (most) [degrees]",
		{"", "0.1 %", "1 %", "contacts or pairs at 1 %", "10 %", "50 %"}, angles);
}

/// B comes from outside, slides through A's side with a rotation, and leaves.
Pose onPath(const Body& A, const Body& B, double s)
{
	Pose X;
	X.rotation = rotationMatrix(quaternionFromRotationVector({0.6 * s, 0.3, 1 - s}));
	const double reach = 0.5 * (A.tree.box.longestSide() + B.tree.box.longestSide());
	const double radius = reach * (0.55 + 0.65 * std::fabs(2 * s - 1));
	const double turn = 1.2 * (s - 0.5);
	X.translation = A.tree.origin + Vec3{std::cos(turn), std::sin(turn), 0.1} * radius - X.rotation * B.tree.origin;
	return X;
}

void comparePath(const std::string& name, const Body& A, const Body& B, Peers& peers, int steps, Page& page)
{
	std::vector<Pose> path;
	std::vector<Truth> truths;
	for (int i = 0; i < steps; ++i)
	{
		path.push_back(onPath(A, B, (i + 0.5) / steps));
		truths.push_back(truthOf(A, B, path.back()));
	}
	const auto jitter = [](const std::vector<Vec3>& pushes) {
		double squares = 0, length = 0;
		for (size_t i = 1; i + 1 < pushes.size(); ++i)
			squares += squaredNorm(pushes[i - 1] - pushes[i] * 2.0 + pushes[i + 1]) / double(pushes.size() - 2);
		for (const Vec3& p : pushes) length += norm(p) / double(pushes.size());
		return length > 0 ? std::sqrt(squares) / length : 0;
	};
	std::vector<Vec3> exact;
	for (const Truth& t : truths) exact.push_back(t.push);
	std::vector<std::vector<std::string>> rows{{"exact gradient", "", "", "0 / 0", "0", scenes::formatNumber(jitter(exact), 2)}};
	for (auto& peer : peers)
	{
		std::vector<double> us, degrees;
		std::vector<Vec3> pushes;
		int hits = 0, misses = 0;
		for (int i = 0; i < steps; ++i)
		{
			bench::PeerAnswer answer;
			us.push_back(timed(*peer, path[size_t(i)], answer));
			pushes.push_back(answer.push);
			hits += answer.contacts > 0 && !truths[size_t(i)].meets;
			misses += answer.contacts == 0 && truths[size_t(i)].meets;
			if (answer.contacts > 0 && truths[size_t(i)].meets && norm(truths[size_t(i)].push) > 0)
				degrees.push_back(angleBetween(answer.push, truths[size_t(i)].push));
		}
		rows.push_back({peer->name(), scenes::formatNumber(quantile(us, 0.5), 3), scenes::formatNumber(quantile(us, 0.99), 3),
			std::to_string(hits) + " / " + std::to_string(misses), scenes::formatNumber(quantile(degrees, 0.5), 2),
			scenes::formatNumber(jitter(pushes), 2)});
	}
	page.table(name + ": a path of " + std::to_string(steps) + " steps",
		{"", "median [us]", "99 % [us]", "false hits / misses", "angle, median [degrees]", "jitter"}, rows);
}

void compareInside(const std::string& name, const Body& A, const Body& B, Peers& peers, Page& page)
{
	Pose X;
	X.translation = A.tree.origin - B.tree.origin;
	// The deepest of the packed spheres holds the probe.
	if (!A.tree.spheres.empty()) X.translation += A.tree.spheres[0].center();
	std::vector<std::vector<std::string>> rows;
	for (auto& peer : peers) rows.push_back({peer->name(), peer->ask(X).contacts > 0 ? "seen" : "not seen"});
	page.table(name + ": the second body in the middle of the first", {"", "contact"}, rows);
}

Body namedBody(const std::string& name, int spheres)
{
	if (name != "probe") return bodyOf(bench::placed(bench::meshNamed(name)), spheres);
	return bodyOf(makeSphereMesh(0.06, 4), std::min(spheres, 1000));
}

bool parse(int argc, char** argv, Settings& s)
{
	for (int i = 1; i < argc; ++i)
	{
		const std::string word = argv[i];
		if (word.rfind("--", 0) != 0)
		{
			s.pairs.push_back(word);
			if (word.find('-') == std::string::npos) return false;
			continue;
		}
		if (++i == argc) return false;
		if (word == "--poses") s.poses = std::atoi(argv[i]);
		else if (word == "--steps") s.steps = std::atoi(argv[i]);
		else if (word == "--spheres") s.spheres = std::atoi(argv[i]);
		else if (word == "--report") s.report = argv[i];
		else return false;
	}
	if (s.pairs.empty()) s.pairs = {"bunny-bunny", "bunny-probe"};
	return s.poses > 0 && s.steps > 2 && s.spheres > 0;
}
}  // namespace

int main(int argc, char** argv)
{
	Settings settings;
	if (!parse(argc, argv, settings))
	{
		std::fprintf(stderr, "usage: bench_peers [--poses N=10] [--steps N=200] [--spheres N=10000] [--report PAGE.html] [A-B]...\n");
		return 2;
	}
	Page page;
	page.html.paragraph("Exact: A's triangles inside of B, cut where they cross its surface. Times are the least of three runs in a row of "
						"a pose, one thread. Peers return contacts, summed up here as "
						"depth times normal; this library stands behind its gate, so that bodies that are apart press nothing.");
	for (const std::string& name : settings.pairs)
	{
		const size_t dash = name.find('-');
		const Body A = namedBody(name.substr(0, dash), settings.spheres), B = namedBody(name.substr(dash + 1), settings.spheres);
		Peers peers;
		for (const bool force : {false, true}) peers.push_back(std::make_unique<Own>(A.tree, B.tree, force));
		for (auto& peer : bench::makePeers(A.mesh, B.mesh)) peers.push_back(std::move(peer));
		comparePoses(name, A, B, peers, settings.poses, page);
		comparePath(name, A, B, peers, settings.steps, page);
		compareInside(name, A, B, peers, page);
	}
	if (settings.report.empty() || page.html.write(settings.report)) return 0;
	std::fprintf(stderr, "bench_peers: cannot write %s\n", settings.report.c_str());
	return 1;
}
