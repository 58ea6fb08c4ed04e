// SPDX-License-Identifier: Zlib
#include "tests/bench/bodies/TruePoses.h"

#include "demos/scenes/Truth/PoseSampler.h"
#include "tests/bench/bodies/BenchBodies.h"

#include <fstream>
#include <iomanip>
#include <sstream>

using namespace ist;

namespace bench
{
namespace
{
/// Visits all numbers of a pose, in the order in which a file has them.
template <class Visit> void visitNumbers(TruePose& p, Visit visit)
{
	const auto vector = [&](Vec3& v) { visit(v.x), visit(v.y), visit(v.z); };
	for (auto& row : p.X_AB.rotation.m)
		for (double& v : row) visit(v);
	vector(p.X_AB.translation);
	for (double* v : {&p.overlap, &p.truth.volume, &p.truth.volumeError, &p.truth.normalError, &p.truth.depthA, &p.truth.depthB}) visit(*v);
	vector(p.truth.centroid);
	for (Wrench* w : {&p.truth.normalA, &p.truth.normalB})
	{
		vector(w->force);
		vector(w->torque);
	}
}

std::vector<TruePose> read(const std::string& path)
{
	std::ifstream file(path);
	size_t count = 0;
	file >> count;
	std::vector<TruePose> poses(file ? count : 0);
	for (TruePose& pose : poses) visitNumbers(pose, [&](double& v) { file >> v; });
	return file ? poses : std::vector<TruePose>();
}

void write(const std::string& path, std::vector<TruePose>& poses)
{
	std::ofstream file(path);
	file << std::setprecision(17) << poses.size() << '\n';
	for (TruePose& pose : poses)
	{
		visitNumbers(pose, [&](double v) { file << v << ' '; });
		file << '\n';
	}
}
}  // namespace

std::vector<TruePose> truePoses(
	const std::string& bodyA, const std::string& bodyB, const TruthSettings& settings, const std::string& folder)
{
	const Mesh A = placed(meshNamed(bodyA)), B = placed(meshNamed(bodyB));
	std::ostringstream name;
	name << folder << '/' << bodyA << '-' << bodyB << '-' << std::hex << meshHash(A) << '-' << meshHash(B) << std::dec << '-'
		 << settings.poses << '-' << settings.lines << '-' << settings.points << '-' << settings.seed;
	for (const double overlap : settings.overlaps) name << '-' << overlap;
	if (!folder.empty())
		if (std::vector<TruePose> kept = read(name.str()); !kept.empty()) return kept;
	const scenes::OverlapQuadrature quadrature(A, B);
	std::vector<TruePose> poses;
	for (const double overlap : settings.overlaps)
		for (const Pose& X : scenes::posesAtOverlap(quadrature, overlap, settings.poses, settings.seed))
			poses.push_back({X, overlap, quadrature.integrate(X, quadrature.extentA().center, settings.lines, settings.points)});
	if (!folder.empty()) write(name.str(), poses);
	return poses;
}
}  // namespace bench
