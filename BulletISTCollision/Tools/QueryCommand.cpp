// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"
#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Base/ThreadCount.h"
#include "BulletISTCollision/Core/Force/ContactPoints.h"
#include "BulletISTCollision/Core/Force/PairLaws.h"
#include "BulletISTCollision/Core/Query/ProximityQuery.h"
#include "BulletISTCollision/Tools/NumberText.h"
#include "BulletISTCollision/Tools/OutputFile.h"
#include "BulletISTCollision/Tools/PoseRows.h"
#include "BulletISTCollision/Tools/Report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace ist::tools
{
namespace
{
int threadNumber()
{
#ifdef _OPENMP
	return omp_get_thread_num();
#else
	return 0;
#endif
}

/// Result of a law for a pose; `overlap` contains pointers into the workspace.
struct Answer
{
	OverlapResult overlap;
	double errorBound = 0;  ///< set with a force tolerance
	bool kept = false;
	Wrench wrench;
	double energy = 0;
	SymmetricMatrix6 stiffness;
	bool enoughPairs = true;
};

struct Row
{
	PoseRow input;
	std::vector<double> times;  ///< [us]
	Report report;
	std::string pairs;                 ///< lines for --pairs-out
	std::vector<ContactPoint> points;  ///< for --surface, in A's mesh frame
};

class Batch
{
public:
	Batch(const QueryArguments& arguments, InnerSphereTree A, InnerSphereTree B)
		: m_arguments(arguments),
		  m_A(std::move(A)),
		  m_B(std::move(B)),
		  m_pair{arguments.stiffness, 0.5, 0.5}
	{
		m_paper = arguments.law == "paper";
		m_energyLaw = arguments.law == "energy";
		m_volumeOnly = arguments.law == "volume";
		m_length = 0.5 * std::max(m_A.box.longestSide(), m_B.box.longestSide());
		if (arguments.level > 0 || arguments.maxPairs >= 0 || arguments.error)
		{
			if (arguments.law != "pressure") m_unsupported = "unsupported: --level, --max-pairs and --error go with --law pressure only";
			addLevels(m_A);
			addLevels(m_B);
		}
		if (arguments.blend && arguments.maxPairs < 0) m_unsupported = "unsupported: --blend needs --max-pairs";
		if (arguments.blend && !arguments.pairsOut.empty())
			m_unsupported = "unsupported: --blend mixes two levels, whose pairs make no one list for --pairs-out";
		if (!arguments.surfaceOut.empty() && (arguments.law != "pressure" || !arguments.pairsOut.empty()))
			m_unsupported = "unsupported: --surface goes with --law pressure, and not with --pairs-out, which asks the leaves";
		if (arguments.gate && (m_paper || m_energyLaw)) m_unsupported = "unsupported: --gate goes with the laws pressure and volume";
	}

	void run(std::vector<Row>& rows) const
	{
		for (Row& row : rows)
			if (row.input.error.empty()) row.input.error = m_unsupported;
		std::vector<size_t> order;
		for (size_t i = 0; i < rows.size(); ++i)
			if (rows[i].input.error.empty()) order.push_back(i);
		if (m_arguments.shuffle) std::shuffle(order.begin(), order.end(), std::mt19937_64(1));
		const int threads = std::min<int>(threadCount(m_arguments.threads), std::max<int>(1, static_cast<int>(order.size())));
		std::vector<QueryWorkspace> workspaces(static_cast<size_t>(threads));
		for (int pass = 0; pass < m_arguments.repeat; ++pass)
		{
#pragma omp parallel for schedule(dynamic) num_threads(threads)
			for (size_t i = 0; i < order.size(); ++i)
				answer(rows[order[i]], order[i], workspaces[static_cast<size_t>(threadNumber())], pass == 0);
		}
		for (size_t i = 0; i < rows.size(); ++i) finish(rows[i], i);
	}

private:
	Model model() const { return m_paper ? Model::Inner : m_volumeOnly ? Model::Cell : Model::Law; }

	void ask(const Pose& X, QueryWorkspace& workspace, const QueryOptions& options, Answer& a) const
	{
		if (!m_arguments.error)
		{
			a.overlap = queryOverlap(m_A, m_B, X, workspace, options);
			return;
		}
		ForceTolerance accepted;
		accepted.error = *m_arguments.error;
		const BoundedOverlap promised = queryWithTolerance(m_A, m_B, X, workspace, accepted, options);
		a.overlap = promised.overlap;
		a.errorBound = promised.errorBound;
		a.kept = promised.kept;
	}

	Answer evaluate(const Pose& X, QueryWorkspace& workspace) const
	{
		Answer a;
		QueryOptions options;
		options.model = model();
		options.stiffness = !m_paper && !m_volumeOnly;
		options.level = m_arguments.level;
		options.maxPairs = m_arguments.maxPairs;
		options.blend = m_arguments.blend;
		options.sortPairs = m_paper || m_energyLaw || !m_arguments.pairsOut.empty();
		options.listMeetingBounds = m_energyLaw;
		options.requireInnerOverlap = m_arguments.gate;
		ask(X, workspace, options, a);
		if (a.overlap.status != QueryStatus::Ok) return a;
		a.enoughPairs = !(m_paper || m_energyLaw) || a.overlap.pairListComplete;
		const OverlapIntegrals& total = a.overlap.total;
		if (m_paper) a.wrench = paperLaw(m_A, m_B, X, a.overlap.pairs, a.overlap.pairCount, m_arguments.stiffness).wrench;
		else if (m_energyLaw)
		{
			const PairLawResult sum = energyLaw(m_A, m_B, X, a.overlap.pairs, a.overlap.pairCount, m_pair);
			a.wrench = sum.wrench;
			a.energy = sum.energy;
		}
		else if (!m_volumeOnly)
		{
			a.wrench = pressureWrench(total, m_pair);
			a.energy = pressureEnergy(total, m_pair);
		}
		if (options.stiffness) a.stiffness = projectedPositive(pressureStiffness(total, m_pair), m_length);
		return a;
	}

	/// If there are more pairs than a workspace holds, the laws that visit pairs get a larger workspace. Its allocation is not timed.
	Answer evaluateAll(const Pose& X, QueryWorkspace& workspace, double& microseconds) const
	{
		for (;;)
		{
			const auto start = std::chrono::steady_clock::now();
			Answer a = evaluate(X, workspace);
			microseconds = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
			const bool wanted = !a.enoughPairs || (!m_arguments.pairsOut.empty() && !a.overlap.pairListComplete);
			if (!wanted || a.overlap.total.pairs >= 100'000'000) return a;
			QueryCapacity larger = workspace.capacity();
			larger.pairs = static_cast<int>(
				std::max<int64_t>(a.overlap.total.pairs + a.overlap.total.pairs / 8, 2 * int64_t(larger.pairs)));
			workspace = QueryWorkspace(larger);
		}
	}

	void answer(Row& row, size_t index, QueryWorkspace& workspace, bool report) const
	{
		double microseconds = 0;
		const Answer a = evaluateAll(row.input.pose, workspace, microseconds);
		row.times.push_back(microseconds);
		if (!report) return;
		if (a.overlap.status != QueryStatus::Ok) row.input.error = toString(a.overlap.status);
		else if (!a.enoughPairs)
			row.input.error = "unsupported: too many intersecting pairs (" + std::to_string(a.overlap.total.pairs) + ") for this law";
		if (!row.input.error.empty()) return;
		if (!m_arguments.pairsOut.empty()) row.pairs = pairLines(a.overlap, index);
		if (!m_arguments.surfaceOut.empty()) row.points = contactSurface(a.overlap);
		// This comes last, because the other queries overwrite the data that the answer points to.
		row.report = describe(a, row.input.pose, index, workspace);
	}

	Report describe(const Answer& a, const Pose& X, size_t index, QueryWorkspace& workspace) const
	{
		const OverlapIntegrals& total = a.overlap.total;
		const bool touching = total.volume > 0;
		const OverlapError error = overlapError(a.overlap, m_A, m_B, m_arguments.stiffness);
		Report r = newReport();
		r["row"] = index;
		r["volume"] = total.volume;
		r["volume_sigma"] = error.volume;
		r["volume_lower"] = m_arguments.lowerBound ? Report(lowerBound(a, X, workspace)) : Report();
		r["energy"] = m_volumeOnly ? Report() : Report(m_paper ? depthEnergy(X, workspace) : a.energy);
		r["centroid"] = touching ? toJson(total.firstMoment / total.volume + m_A.origin) : Report();
		r["normal"] = touching ? toJson(normalized(total.areaVector)) : Report();
		r["area_vector"] = touching ? toJson(total.areaVector) : Report();
		r["force"] = m_volumeOnly ? Report() : toJson(a.wrench.force);
		r["force_sigma"] = m_volumeOnly ? Report() : Report(error.force);
		r["torque"] = m_volumeOnly ? Report() : toJson(a.wrench.torque);
		r["stiffness"] = m_volumeOnly || m_paper ? Report() : matrix(a.stiffness);
		r["patches"] = a.overlap.patchCount;
		r["pairs"] = total.pairs;
		const Distance distance = touching ? Distance{} : queryDistance(m_A, m_B, X);
		r["distance"] = distance.upper;
		r["distance_lower"] = distance.lower;
		r["nearest_a"] = touching || !std::isfinite(distance.upper) ? Report() : toJson(distance.pointA);
		r["nearest_b"] = touching || !std::isfinite(distance.upper) ? Report() : toJson(distance.pointB);
		r["time_us"] = nullptr;
		r["level"] = a.overlap.level;
		r["level_share"] = a.overlap.levelShare;
		r["promise"] = m_arguments.error ? Report(a.errorBound) : Report();
		r["kept"] = m_arguments.error ? Report(a.kept) : Report();
		r["complete"] = a.overlap.pairListComplete && !a.overlap.coarsened;
		return r;
	}

	static Report matrix(const SymmetricMatrix6& m)
	{
		Report r = Report::list();
		for (int i = 0; i < 6; ++i)
			for (int j = 0; j < 6; ++j) r.append(m(i, j));
		return r;
	}

	double lowerBound(const Answer& a, const Pose& X, QueryWorkspace& workspace) const
	{
		if (m_paper) return a.overlap.total.volume;
		QueryOptions options;
		options.model = Model::Inner;
		options.stiffness = options.patches = false;
		return queryOverlap(m_A, m_B, X, workspace, options).total.volume;
	}

	/// Elastic energy from the leaves, for paper mode: packed spheres have no depth.
	double depthEnergy(const Pose& X, QueryWorkspace& workspace) const
	{
		QueryOptions options;
		options.stiffness = options.patches = false;
		return pressureEnergy(queryOverlap(m_A, m_B, X, workspace, options).total, m_pair);
	}

	std::vector<ContactPoint> contactSurface(const OverlapResult& overlap) const
	{
		std::vector<ContactPoint> points(contactPointCount(overlap));
		contactPoints(overlap, m_pair, points.data(), points.size());
		for (ContactPoint& p : points) p.position += m_A.origin;
		return points;
	}

	std::string pairLines(const OverlapResult& overlap, size_t index) const
	{
		std::string text;
		for (int i = 0; i < overlap.pairCount; ++i)
		{
			const OverlapPair& p = overlap.pairs[i];
			const Vec3 c = p.centroid + m_A.origin;
			for (uint64_t id :
				{uint64_t(index), uint64_t(overlap.ballsA->ball(p.ballA).sphere), uint64_t(overlap.ballsB->ball(p.ballB).sphere)})
				text += std::to_string(id) + ',';
			for (double v : {c.x, c.y, c.z, p.normal.x, p.normal.y, p.normal.z}) text += numberText(v) + ',';
			text += numberText(p.lens) + ',' + numberText(p.area) + '\n';
		}
		return text;
	}

	static double median(std::vector<double> v)
	{
		std::sort(v.begin(), v.end());
		const size_t n = v.size();
		return n % 2 ? v[n / 2] : 0.5 * (v[n / 2 - 1] + v[n / 2]);
	}

	static void finish(Row& row, size_t index)
	{
		if (row.input.error.empty())
		{
			row.report["time_us"] = median(row.times);
			return;
		}
		row.report = newReport();
		row.report["row"] = index;
		row.report["error"] = row.input.error;
	}

	const QueryArguments& m_arguments;
	InnerSphereTree m_A, m_B;
	PressurePair m_pair;
	bool m_paper = false, m_energyLaw = false, m_volumeOnly = false;
	double m_length = 1;  ///< length that makes rotations comparable with translations [m]
	std::string m_unsupported;
};

Result<std::vector<Row>> readRows(const QueryArguments& a)
{
	std::vector<PoseRow> poses;
	if (!a.pose.empty()) poses.push_back(parsePose(a.pose));
	else
	{
		Result<std::vector<PoseRow>> read = readPoses(a.poses);
		if (!read) return read.error();
		poses = std::move(read).value();
	}
	std::vector<Row> rows(poses.size());
	for (size_t i = 0; i < poses.size(); ++i) rows[i].input = poses[i];
	return rows;
}

int writeSurface(const std::string& path, const std::vector<Row>& rows)
{
	size_t count = 0;
	for (const Row& row : rows) count += row.points.size();
	std::string text = "ply\nformat ascii 1.0\ncomment contact surface in A's mesh frame; lengths in m, pressures in Pa\nelement vertex " +
		std::to_string(count) + "\n";
	for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "area", "pressure", "error"})
		text += std::string("property double ") + name + "\n";
	text += "property uchar of_a\nproperty uint row\nend_header\n";
	for (size_t i = 0; i < rows.size(); ++i)
		for (const ContactPoint& p : rows[i].points)
		{
			for (const double v :
				{p.position.x, p.position.y, p.position.z, p.normal.x, p.normal.y, p.normal.z, p.area, p.pressure, p.error})
				text += numberText(v) + ' ';
			text += std::to_string(int(p.ofA)) + ' ' + std::to_string(i) + '\n';
		}
	return writeText(path, text);
}

int writePairs(const std::string& path, const std::vector<Row>& rows)
{
	std::string text = "row,sphere_a,sphere_b,x,y,z,nx,ny,nz,volume,area\n";
	for (const Row& row : rows) text += row.pairs;
	return writeText(path, text);
}
}  // namespace

int runQuery(const QueryArguments& a)
{
	if (!a.pairsOut.empty())
		if (const int code = checkOutput(a.pairsOut, {a.fileA, a.fileB, a.poses}); code != kGood) return code;
	if (!a.surfaceOut.empty())
		if (const int code = checkOutput(a.surfaceOut, {a.fileA, a.fileB, a.poses}); code != kGood) return code;
	Result<InnerSphereTree> A = loadTree(a.fileA);
	if (!A) return fail(A.error().message);
	Result<InnerSphereTree> B = a.fileA == a.fileB ? A : loadTree(a.fileB);
	if (!B) return fail(B.error().message);
	if (a.pose.empty() && a.poses.empty())
		return fail("a query needs the pose of B in A's mesh frame: --pose tx,ty,tz,qx,qy,qz,qw, or --poses and a CSV file", kUsage);
	Result<std::vector<Row>> rows = readRows(a);
	if (!rows) return fail(rows.error().message);
	Batch(a, std::move(A).value(), std::move(B).value()).run(rows.value());

	int code = kGood;
	for (const Row& row : rows.value())
	{
		std::fputs(format(row.report, a.json).c_str(), stdout);
		if (!a.json && rows.value().size() > 1) std::fputs("\n", stdout);
		if (!row.input.error.empty()) code = kBadInput;
	}
	if (!a.pairsOut.empty())
		if (const int written = writePairs(a.pairsOut, rows.value()); written != kGood) return written;
	if (!a.surfaceOut.empty())
		if (const int written = writeSurface(a.surfaceOut, rows.value()); written != kGood) return written;
	return code;
}
}  // namespace ist::tools
