// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/AssetFile.h"
#include "BulletISTCollision/Core/ForcePromise.h"
#include "BulletISTCollision/Core/LevelCalibration.h"
#include "BulletISTCollision/Core/MeshImport.h"
#include "BulletISTCollision/Core/OverlapPoses.h"
#include "BulletISTCollision/Core/TreeBuilder.h"
#include "BulletISTCollision/Core/TreeLevels.h"
#include "BulletISTCollision/Tools/Interruption.h"
#include "BulletISTCollision/Tools/NumberText.h"
#include "BulletISTCollision/Tools/Report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

namespace ist::tools
{
namespace
{
constexpr int kPosesPerOverlap = 10, kPasses = 3;
constexpr int64_t kFirstSpheres = 1000, kSpheresStep = 3;
constexpr double kHeld = 0.95;

/// A body as the user named it: an asset, or a mesh of which trees are built.
struct Source
{
	std::string path;
	std::optional<Mesh> mesh;
	InnerSphereTree tree;
};

/// What one setting promises and costs over the poses.
struct Setting
{
	int level = 0;  ///< -1: chosen anew in every pose
	double error = 0;  ///< force error that 95 % of the poses stay under, of max(|F|, floor)
	double microseconds = 0, pairs = 0;  ///< median; mean
};

double median(std::vector<double> values)
{
	const auto at = values.begin() + ptrdiff_t(values.size() / 2);
	std::nth_element(values.begin(), at, values.end());
	return *at;
}

/// The error that 95 % of the poses stay under: each promise is twice the standard deviation of a normal error.
double jointError(const std::vector<double>& promises)
{
	const auto held = [&](double error)
	{
		double sum = 0;
		for (double promise : promises) sum += promise > 0 ? std::erf(std::sqrt(2.0) * error / promise) : 1;
		return sum / double(promises.size());
	};
	double low = 0, high = *std::max_element(promises.begin(), promises.end());
	for (int i = 0; i < 60; ++i)
	{
		const double middle = 0.5 * (low + high);
		(held(middle) < kHeld ? low : high) = middle;
	}
	return high;
}

/// Asks `query` about all poses, some times over.
template <class Query>
Setting measured(const std::vector<Pose>& poses, int level, const Query& query)
{
	Setting setting;
	setting.level = level;
	std::vector<double> times(poses.size(), 1e300), errors(poses.size());
	for (int pass = 0; pass < kPasses; ++pass)
		for (size_t i = 0; i < poses.size(); ++i)
		{
			const auto start = std::chrono::steady_clock::now();
			const PromisedOverlap answer = query(poses[i]);
			times[i] = std::min(times[i], std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
			errors[i] = answer.promise;
			setting.pairs += double(answer.overlap.total.pairs) / double(kPasses * poses.size());
		}
	setting.error = jointError(errors);
	setting.microseconds = median(times);
	return setting;
}

/// All fixed levels, the finest first, and at the end the choice by pose.
std::vector<Setting> settingsOf(const InnerSphereTree& A, const InnerSphereTree& B, double error)
{
	QueryWorkspace workspace;
	std::mt19937_64 random(1);
	std::vector<Pose> poses;
	for (const double overlap : kOverlapsOfContact)
		for (int i = 0; i < kPosesPerOverlap; ++i)
			if (const std::optional<Pose> X = poseAtOverlap(A, B, overlap, 0, random, workspace)) poses.push_back(*X);
	std::vector<Setting> settings;
	if (poses.empty()) return settings;
	std::shuffle(poses.begin(), poses.end(), random);
	AcceptedError any, accepted;
	accepted.error = error;
	for (int level = 0; level <= levelCount(A, B); ++level)
	{
		any.firstLevel = level;
		any.error = 1e300;
		settings.push_back(measured(poses, level, [&](const Pose& X) { return queryToError(A, B, X, workspace, any); }));
	}
	settings.push_back(measured(poses, -1, [&](const Pose& X) { return queryToError(A, B, X, workspace, accepted); }));
	return settings;
}

Result<Source> sourceOf(const std::string& path)
{
	Source source{path, std::nullopt, {}};
	const std::string end = std::filesystem::path(path).extension().string();
	if (end == ".ist" || end == ".ista")
	{
		Result<InnerSphereTree> tree = loadAsset(path);
		if (!tree) return tree.error();
		source.tree = std::move(tree).value();
		addLevels(source.tree);
		return source;
	}
	Result<Mesh> mesh = importMesh(path);
	if (!mesh) return mesh.error();
	source.mesh = std::move(mesh).value();
	return source;
}

/// Empty when there is a tree of so many spheres.
std::string rebuild(Source& source, int64_t spheres)
{
	if (!source.mesh) return {};
	BuildOptions options;
	options.maxSpheres = spheres;
	options.progress = [](const char*, double) { return !interrupted(); };
	Result<InnerSphereTree> tree = buildTree(*source.mesh, options);
	if (!tree) return source.path + ": " + tree.error().message;
	source.tree = std::move(tree).value();
	addLevels(source.tree);
	return {};
}

Report describe(const Setting& setting, const InnerSphereTree& A, const InnerSphereTree& B)
{
	Report r;
	r["spheres"] = std::max(A.spheres.size(), B.spheres.size());
	r["level"] = setting.level < 0 ? Report("by pose") : Report(setting.level);
	r["error"] = setting.error;
	r["time_us"] = setting.microseconds;
	r["pairs"] = setting.pairs;
	return r;
}

/// Trees of more and more spheres where a body is a mesh, until a level promises the error.
class Tuning
{
public:
	Tuning(const TuneArguments& arguments, Source A, Source B) : m_arguments(arguments), m_A(std::move(A)), m_B(std::move(B)) {}

	int run()
	{
		const bool builds = m_A.mesh || m_B.mesh;
		for (int64_t spheres = std::min(kFirstSpheres, m_arguments.spheres);; spheres = std::min(kSpheresStep * spheres, m_arguments.spheres))
		{
			for (Source* source : {&m_A, &m_B})
				if (const std::string problem = rebuild(*source, spheres); !problem.empty())
					return interrupted() ? fail("interrupted", kInterrupted) : fail(problem);
			const std::vector<Setting> settings = settingsOf(m_A.tree, m_B.tree, m_arguments.error);
			if (settings.empty()) return fail("the bodies cannot overlap by 0.1 % of the smaller one when their centres of mass meet");
			if (take(settings) || !builds || spheres == m_arguments.spheres) return print();
		}
	}

private:
	/// True when a fixed level promises the error: the cheapest that does is the answer so far, else the one of the smallest error.
	bool take(const std::vector<Setting>& settings)
	{
		const auto keeps = [&](const Setting& s) { return s.error <= m_arguments.error; };
		const auto better = [&](const Setting& a, const Setting& b)
		{ return keeps(a) != keeps(b) ? keeps(a) : keeps(a) ? a.microseconds < b.microseconds : a.error < b.error; };
		const auto best = std::min_element(settings.begin(), settings.end() - 1, better);
		m_answer = newReport();
		m_answer.update(describe(*best, m_A.tree, m_B.tree));
		m_answer["spheres_a"] = m_A.tree.spheres.size();
		m_answer["spheres_b"] = m_B.tree.spheres.size();
		m_answer["kept"] = m_kept = keeps(*best);
		for (const Setting& setting : settings) m_alternatives.push_back(describe(setting, m_A.tree, m_B.tree));
		return m_kept;
	}

	int print()
	{
		m_answer["alternatives"] = m_alternatives;
		std::fputs(format(m_answer, m_arguments.json).c_str(), stdout);
		if (m_kept) return kGood;
		return fail("a force error of " + numberText(m_arguments.error) + " is out of reach of these trees: " + numberText(m_answer["error"].get<double>()) +
					" is promised; build them with more spheres, or accept more");
	}

	const TuneArguments& m_arguments;
	Source m_A, m_B;
	Report m_answer, m_alternatives = Report::array();
	bool m_kept = false;
};
}  // namespace

int runTune(const TuneArguments& a)
{
	catchInterrupts();
	Result<Source> A = sourceOf(a.fileA);
	if (!A) return fail(A.error().message);
	Result<Source> B = a.fileA == a.fileB ? A : sourceOf(a.fileB);
	if (!B) return fail(B.error().message);
	return Tuning(a, std::move(A).value(), std::move(B).value()).run();
}
}  // namespace ist::tools
