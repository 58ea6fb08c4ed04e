// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Build/TreeBuilder.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Base/SteadyTime.h"
#include "BulletISTCollision/Core/Base/ThreadCount.h"
#include "BulletISTCollision/Core/Leaves/Cells.h"
#include "BulletISTCollision/Core/Mesh/FacetSagitta.h"
#include "BulletISTCollision/Core/Packing/SpherePacker.h"
#include "BulletISTCollision/Core/Repair/RepairChoice.h"
#include "BulletISTCollision/Core/Tree/SurfaceResolution.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <optional>
#include <utility>

namespace ist
{
namespace
{
constexpr int64_t kMostSpheresForLeaves = 100000;
/// Cells of the depth field, and elements of the surface, of a body of 1,000 spheres.
constexpr double kPiecesOfThousand = 1000;
/// Error up to which a surface needs no more pieces, as a share of the mean gap, where the mesh's own sagitta is smaller.
constexpr double kSurfaceErrorOfGap = 0.05;

/// Whether leaves of smooth bodies are split further: true unless the build has a target fill or a smallest radius.
bool splitsSmoothBodies(const BuildOptions& options) { return options.targetFill >= 1 && options.minRadius <= 0; }

class Stopwatch
{
public:
	/// Seconds since construction or the last call.
	double lap()
	{
		const double before = m_start;
		m_start = steadyMicroseconds();
		return 1e-6 * (m_start - before);
	}

private:
	double m_start = steadyMicroseconds();
};

bool goesOn(const Progress& progress, const char* stage, double fraction) { return !progress || progress(stage, fraction); }

Error cancelled() { return {"the build was cancelled", true}; }

void describe(InnerSphereTree& tree, const Mesh& source, const RepairedMesh& repaired, const BuildOptions& options)
{
	InnerSphereTree::Provenance& p = tree.provenance;
	p.meshHash = meshHash(source);
	p.unit = options.unit;
	p.meshVolume = repaired.volumeBefore;
	p.watertight = repaired.before.watertight;
	p.repairMode = repairText({options.repair, options.ground});
	p.repair = repaired.actions;
	p.requestedSpheres = options.maxSpheres;
	p.requestedFill = options.targetFill;
	p.requestedMinRadius = options.minRadius;
	p.seed = options.seed;

	const MassProperties mass = massProperties(repaired.mesh);
	tree.origin = mass.centerOfMass;
	tree.volume = mass.volume;
	tree.inertia = mass.inertia;
	tree.area = surfaceArea(repaired.mesh);
	tree.sagitta = facetSagitta(repaired.mesh);
}

Result<SpherePacking> pack(const MeshDistance& surface, const Vec3& origin, const BuildOptions& options)
{
	PackingOptions packing;
	packing.maxSpheres = options.maxSpheres;
	packing.targetFill = options.targetFill;
	packing.minRadius = options.minRadius;
	packing.seed = options.seed;
	packing.threads = options.threads;
	packing.progress = options.progress;
	packing.origin = origin;
	return packSpheres(surface, packing);
}

/// More spheres ask for a finer surface, but its error falls faster than that of the leaves.
BodySurfaceOptions surfaceOptions(const BuildOptions& options)
{
	BodySurfaceOptions surface;
	const double spheres = double(std::clamp<int64_t>(options.maxSpheres, 1, kMostSpheresForLeaves));
	surface.cells = surface.elements = int64_t(kPiecesOfThousand * std::pow(spheres / 1000, spheres < 1000 ? 1.0 / 2 : 1.0 / 3));
	surface.seed = options.seed;
	surface.threads = options.threads;
	surface.progress = options.progress;
	return surface;
}

/// The elements of the surface. One thread builds them; where there are several, it does so beside the packing.
class SurfaceElements
{
public:
	/// Keeps a reference to the mesh.
	SurfaceElements(const Mesh& mesh, const BodySurfaceOptions& options)
	{
		const bool isBeside = threadCount(options.threads) > 1;
		ContactSurfaceOptions own{options.elements, options.progress};
		// Progress is reported from the thread of the caller alone.
		if (isBeside) own.progress = [this](const char*, double) { return !m_isCancelled; };
		m_result = std::async(
			isBeside ? std::launch::async : std::launch::deferred, [&mesh, own] { return buildContactSurface(mesh, own); });
	}
	~SurfaceElements() { m_isCancelled = true; }
	SurfaceElements(const SurfaceElements&) = delete;
	SurfaceElements& operator=(const SurfaceElements&) = delete;

	/// Waits for them. To be called once.
	Result<ContactSurface> take() { return m_result.get(); }

private:
	std::atomic<bool> m_isCancelled{false};
	std::future<Result<ContactSurface>> m_result;  ///< its destructor waits
};

/// Returns false when the build was cancelled.
bool buildTrees(InnerSphereTree& tree, const Cells& cells, int threads, const Progress& progress)
{
	if (!goesOn(progress, "tree", 0)) return false;
	tree.law = buildBallTree(cells.leaves, threads);
	tree.resolution = surfaceResolution(tree.law);
	if (!goesOn(progress, "tree", 0.4)) return false;
	tree.cells = buildBallTree(cells.cells, threads);
	if (!goesOn(progress, "tree", 0.6)) return false;
	tree.inner = buildInnerTree(tree.spheres, threads);
	if (!goesOn(progress, "tree", 0.8)) return false;
	// The levels are discarded, because building them again is faster than reading them. Only their calibration is saved.
	InnerSphereTree levelled = tree;
	addLevels(levelled, threads);
	tree.calibration = levelled.calibration;
	return goesOn(progress, "tree", 1);
}
}  // namespace

bool leavesBecomeSmaller(const BuildOptions& options) { return splitsSmoothBodies(options) && options.maxSpheres < kMostSpheresForLeaves; }

Result<InnerSphereTree> buildTree(const Mesh& mesh, const BuildOptions& options, BuildTimes* times)
{
	Stopwatch watch;
	const Result<RepairedMesh> repaired = repairToBuild(mesh, options);
	if (!repaired) return repaired.error();
	const double repairing = watch.lap();
	Result<InnerSphereTree> tree = buildRepaired(mesh, repaired.value(), options, times);
	if (times) times->setup += repairing;
	return tree;
}

Result<RepairedMesh> repairToBuild(const Mesh& mesh, const BuildOptions& options)
{
	if (!goesOn(options.progress, "repair", 0)) return cancelled();
	Progress repairing;
	if (options.progress) repairing = [&](const char* stage, double fraction) { return options.progress(stage, 0.9 * fraction); };
	return repair(mesh, options.repair, repairing, threadCount(options.threads), options.ground);
}

Result<InnerSphereTree> buildRepaired(const Mesh& mesh, const RepairedMesh& repaired, const BuildOptions& options, BuildTimes* times)
{
	Stopwatch watch;
	BuildTimes unused;
	BuildTimes& seconds = times ? *times : unused;
	InnerSphereTree tree;

	const int threads = threadCount(options.threads);
	describe(tree, mesh, repaired, options);
	const MeshDistance surface(translated(repaired.mesh, -tree.origin), threads);
	tree.box = bounds(surface.mesh());
	if (!goesOn(options.progress, "repair", 1)) return cancelled();
	seconds.setup = watch.lap();

	std::optional<SurfaceElements> elements;
	BodySurfaceOptions ofSurface = surfaceOptions(options);
	if (options.surface) elements.emplace(surface.mesh(), ofSurface);

	Result<SpherePacking> packing = pack(surface, tree.origin, options);
	if (!packing) return packing.error();
	tree.fill = packing.value().fill;
	seconds.packing = watch.lap();

	CellOptions cellOptions;
	// A few spheres fill a smooth body. Its leaves must still be as small as `maxSpheres` allows.
	if (splitsSmoothBodies(options))
		cellOptions.fewestLeaves = int64_t(cellOptions.leavesPerSphere * double(std::min(options.maxSpheres, kMostSpheresForLeaves)));
	cellOptions.seed = options.seed;
	cellOptions.threads = options.threads;
	cellOptions.progress = options.progress;
	const Result<Cells> cells = buildCells(surface, packing.value(), cellOptions);
	if (!cells) return cells.error();
	tree.meanGap = cells.value().meanGap;
	tree.maxGap = cells.value().maxGap;
	tree.uncoveredArea = cells.value().uncoveredArea;
	tree.spheres = std::move(packing.value().spheres);
	seconds.leaves = watch.lap();

	if (elements)
	{
		Result<ContactSurface> taken = elements->take();
		if (!goesOn(options.progress, "surface", 1)) return cancelled();
		ofSurface.error = std::max(tree.sagitta, kSurfaceErrorOfGap * tree.meanGap);
		Result<BodySurface> body = buildBodySurface(surface, std::move(taken), ofSurface);
		if (!body) return body.error();
		tree.surface = std::move(body.value());
	}
	seconds.surface = watch.lap();

	if (!buildTrees(tree, cells.value(), threads, options.progress)) return cancelled();
	seconds.tree = watch.lap();
	if (const std::string problem = tree.validate(); !problem.empty()) return Error{"internal: the built tree is not valid: " + problem};
	return tree;
}
}  // namespace ist
