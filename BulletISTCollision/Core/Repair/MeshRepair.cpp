// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include "BulletISTCollision/Core/Mesh/MatchingVertices.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Core/Mesh/MeshEdges.h"
#include "BulletISTCollision/Core/Repair/MeshCuts.h"
#include "BulletISTCollision/Core/Repair/MeshHoles.h"
#include "BulletISTCollision/Core/Repair/MeshJunctions.h"
#include "BulletISTCollision/Core/Repair/MeshOrientation.h"
#include "BulletISTCollision/Core/Repair/MeshProbes.h"
#include "BulletISTCollision/Core/Repair/MeshShells.h"
#include "BulletISTCollision/Core/Repair/MeshThinning.h"
#include "BulletISTCollision/Core/Repair/MeshWeld.h"
#include "BulletISTCollision/Core/Repair/MeshWrap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace ist
{
namespace
{
/// Share of the longest side within which positions are equal in Auto mode, if the mesh is open otherwise.
constexpr double kNearlyEqual = 1e-9;
/// Share of the area times the longest side. A smaller volume counts as none, however far apart the parts that enclose it are.
constexpr double kFlat = 1e-9;
constexpr int64_t kMostCuts = 1000;
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
constexpr int kWrapCells = 16;  // the same cases with a sixtieth of the work
#else
constexpr int kWrapCells = 128;
#endif
/// Distance by which triangles of the grid may be merged, in cells.
constexpr double kThinning = 0.1;
/// An open mesh is not rebuilt if more than this many times its inside is ambiguous, nor a closed one if so much is counted wrongly.
constexpr double kHopeless = 2, kHopelessCuts = 8;
/// Share of the volume. If less is counted wrongly, the surface stays as it is.
constexpr double kHarmless = 0.01;
/// Share of the volume that walls count twice if they differ by rounding only.
constexpr double kRounding = 1e-6;
/// Largest share of the inside that rebuilding may lose, however much is counted wrongly.
constexpr double kMostLost = 0.5;
/// Limits of the longest side of a tree [m]: the smallest spheres that the packer makes, and moments that fit into floats (kMostReach).
constexpr double kShortestSide = 1e-7, kLongestSide = 1e7;

std::string counted(int64_t n, const char* singular, const char* plural) { return std::to_string(n) + " " + (n == 1 ? singular : plural); }

bool indicesAreValid(const Mesh& mesh, const Triangle& t)
{
	return std::all_of(t.begin(), t.end(), [&](uint32_t corner) { return corner < mesh.vertices.size(); });
}

/// The corners of a triangle in ascending order, and whether the triangle lists them in an even permutation.
struct TriangleKey
{
	Triangle corners;
	bool even;
	uint32_t triangle;
};

std::vector<TriangleKey> sortedTriangles(const Mesh& mesh)
{
	std::vector<TriangleKey> keys;
	keys.reserve(mesh.triangles.size());
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		Triangle t = mesh.triangles[i];
		if (isCollapsed(t)) continue;
		std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
		const bool even = t[1] < t[2];
		if (!even) std::swap(t[1], t[2]);
		keys.push_back({t, even, static_cast<uint32_t>(i)});
	}
	const auto firstTwo = [](const TriangleKey& key) { return uint64_t(key.corners[0]) << 32 | key.corners[1]; };
	const auto rest = [](const TriangleKey& key) { return uint64_t(key.corners[2]) << 32 | key.triangle; };
	std::sort(keys.begin(), keys.end(), [&](const TriangleKey& a, const TriangleKey& b) {
		return firstTwo(a) != firstTwo(b) ? firstTwo(a) < firstTwo(b) : rest(a) < rest(b);
	});
	return keys;
}

int64_t countDuplicates(const Mesh& mesh)
{
	const std::vector<TriangleKey> keys = sortedTriangles(mesh);
	int64_t count = 0;
	for (std::size_t i = 1; i < keys.size(); ++i) count += keys[i].corners == keys[i - 1].corners;
	return count;
}

/// Findings for a welded mesh.
Closedness closedness(const Mesh& mesh)
{
	Closedness found;
	const std::vector<EdgeUse> edges = sortedEdges(mesh);
	bool balanced = true;
	forEachEdge(edges, [&](const EdgeUse* use, std::size_t count) {
		int64_t balance = 0;
		for (std::size_t i = 0; i < count; ++i) balance += use[i].forward ? 1 : -1;
		balanced = balanced && balance == 0;
		if (count == 1) ++found.openEdges;
		else if (count > 2) ++found.nonManifoldEdges;
		else if (use[0].forward == use[1].forward) ++found.flippedEdges;
	});
	const std::vector<uint32_t> component = componentOfTriangle(mesh, edges);
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const Triangle& t = mesh.triangles[i];
		const Vec3& a = mesh.vertices[t[0]];
		if (isCollapsed(t) || squaredNorm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a)) == 0) ++found.degenerateTriangles;
		if (!isCollapsed(t) && component[i] == i) ++found.components;
	}
	found.duplicateTriangles = countDuplicates(mesh);
	found.watertight = !edges.empty() && balanced;
	return found;
}

int64_t dropCollapsed(Mesh& mesh) { return static_cast<int64_t>(std::erase_if(mesh.triangles, isCollapsed)); }

/// Treatment of triangles that lie on each other and face opposite ways. They are the two sides of a doubled surface (keep one), or the
/// wall between two bodies that touch (keep none). Cancel drops such pairs and changes nothing else: balanced edges stay balanced.
enum class OppositePairs
{
	KeepOne,
	DropBoth,
	Cancel
};

int64_t dropDuplicates(Mesh& mesh, OppositePairs policy)
{
	const std::vector<TriangleKey> keys = sortedTriangles(mesh);
	std::vector<uint8_t> keep(mesh.triangles.size(), 1), isOfPair(mesh.triangles.size(), 0);
	for (std::size_t i = 0; i < keys.size();)
	{
		std::size_t j = i;
		int64_t balance = 0;
		for (; j < keys.size() && keys[j].corners == keys[i].corners; ++j)
		{
			balance += keys[j].even ? 1 : -1;
			keep[keys[j].triangle] = 0;
		}
		int64_t survivors = policy == OppositePairs::Cancel ? std::abs(balance) : balance != 0 || policy == OppositePairs::KeepOne;
		for (std::size_t k = i; k < j && survivors > 0; ++k)
			if (balance == 0 || keys[k].even == (balance > 0))
			{
				keep[keys[k].triangle] = 1;
				isOfPair[keys[k].triangle] = balance == 0;
				--survivors;
			}
		i = j;
	}
	// Which of the two sides is kept is no choice of the file. Outwards is right for a body, and for one that fills a cavity.
	Mesh pairs{mesh.vertices, {}, mesh.rounding};
	for (std::size_t i = 0; i < keep.size(); ++i)
		if (keep[i] && isOfPair[i]) pairs.triangles.push_back(mesh.triangles[i]);
	if (!pairs.triangles.empty()) faceOutwards(pairs);
	std::size_t kept = 0, ofPairs = 0;
	for (std::size_t i = 0; i < keep.size(); ++i)
		if (keep[i]) mesh.triangles[kept++] = isOfPair[i] ? pairs.triangles[ofPairs++] : mesh.triangles[i];
	const auto dropped = static_cast<int64_t>(mesh.triangles.size() - kept);
	mesh.triangles.resize(kept);
	return dropped;
}

/// Progress of a repair. It remembers that the caller wants to cancel.
class Steps
{
public:
	explicit Steps(const Progress& progress) : m_progress(progress) {}
	bool reach(double fraction)
	{
		m_fraction = std::max(m_fraction, fraction);
		m_goesOn = m_goesOn && (!m_progress || m_progress("repair", m_fraction));
		return m_goesOn;
	}
	bool goesOn() const { return m_goesOn; }
	/// Progress callback for a part of the work that begins now and ends at `end`.
	Progress upTo(double end)
	{
		return [this, begin = m_fraction, end](const char*, double fraction) { return reach(begin + (end - begin) * fraction); };
	}

private:
	const Progress& m_progress;
	double m_fraction = 0;
	bool m_goesOn = true;
};

/// A mesh that is being closed.
struct Attempt
{
	Mesh mesh;
	Closedness state;
	std::vector<std::string> actions;
	double doubt = 0;
	int64_t holes = 0;         ///< number of holes that were closed
	bool contradicts = false;  ///< closing them turned much that was clearly inside to outside, or the reverse
	bool mayOverlap = false;   ///< see ShellVerdict

	void note(int64_t count, const char* verb, const char* singular, const char* plural)
	{
		if (count) actions.push_back(verb + (" " + counted(count, singular, plural)) + ".");
	}
	bool isManifold() const { return state.watertight && state.nonManifoldEdges == 0; }
};

void clean(Attempt& attempt, OppositePairs policy)
{
	attempt.note(dropCollapsed(attempt.mesh), "Dropped", "triangle with repeated corners", "triangles with repeated corners");
	attempt.note(dropDuplicates(attempt.mesh, policy), "Dropped", "duplicate triangle", "duplicate triangles");
}

void weldSeams(Attempt& attempt, OppositePairs policy)
{
	const double side = bounds(attempt.mesh).longestSide();
	WeldedVertices all;
	for (const double apart : {kNearlyEqual * side, weldingTolerance(attempt.mesh)})
	{
		const std::vector<uint32_t> open = verticesOfOpenEdges(attempt.mesh);
		if (open.empty() || !(apart > 0)) break;
		const WeldedVertices welded = weldNear(attempt.mesh, open, apart);
		all.count += welded.count;
		all.doubt += welded.doubt;
		if (welded.count) clean(attempt, policy);
	}
	attempt.note(all.count, "Welded", "nearly equal vertex", "nearly equal vertices");
	attempt.doubt += all.doubt;
}

void divideSeams(Attempt& attempt, OppositePairs policy)
{
	const DividedEdges divided = divideOpenEdges(
		attempt.mesh, std::max(kNearlyEqual * bounds(attempt.mesh).longestSide(), weldingTolerance(attempt.mesh)));
	if (!divided.count) return;
	attempt.actions.push_back("Divided " + counted(divided.count, "open edge", "open edges") + " at vertices that lie on " +
		(divided.count > 1 ? "them." : "it."));
	attempt.doubt += divided.doubt;
	clean(attempt, policy);
}

/// Applies all repairs that need no new surface.
Attempt cleaned(const Mesh& welded, OppositePairs policy)
{
	Attempt attempt{welded, {}, {}, 0};
	clean(attempt, policy);
	weldSeams(attempt, policy);
	divideSeams(attempt, policy);
	attempt.note(
		orientConsistently(attempt.mesh), "Turned", "triangle to agree with its neighbours", "triangles to agree with their neighbours");
	attempt.state = closedness(attempt.mesh);
	return attempt;
}

void settle(Attempt& attempt)
{
	const ShellVerdict verdict = settleShells(attempt.mesh);
	attempt.note(verdict.dropped, "Dropped", "sheet without volume", "sheets without volume");
	attempt.note(verdict.turned, "Turned", "inside-out shell", "inside-out shells");
	attempt.note(verdict.redundant, "Dropped", "shell inside solid material", "shells inside solid material");
	attempt.mayOverlap = verdict.mayOverlap;
}

void closeHoles(Attempt& attempt)
{
	const Mesh open = attempt.mesh;
	const ClosedHoles closed = closeHoles(attempt.mesh);
	attempt.holes = closed.count;
	attempt.doubt += closed.doubt;
	if (closed.count)
		attempt.actions.push_back("Closed " + counted(closed.count, "hole", "holes") + (closed.count > 1 ? ", the largest " : ", ") +
			number(closed.largest.extent) + " m across at " + place(closed.largest.middle) +
			"; what is missing there may change the volume by " + number(closed.doubt) + " m^3.");
	dropDuplicates(attempt.mesh, OppositePairs::Cancel);
	attempt.state = closedness(attempt.mesh);
	// The mesh consisted only of sheets that were each closed by their own reverse.
	if (attempt.mesh.triangles.empty()) attempt.state.watertight = closed.count > 0;
	attempt.contradicts = closed.doubt + closed.doubtOfSheets > kHarmless * std::fabs(massProperties(attempt.mesh).volume) &&
		contradictedShare(open, attempt.mesh, probesAlong(open)) > kHarmless;
}

Attempt closeUp(const Mesh& welded, OppositePairs policy, Steps& steps, double end)
{
	const Progress part = steps.upTo(end);
	Attempt attempt = cleaned(welded, policy);
	if (!part("repair", 0.5)) return attempt;
	if (!attempt.state.watertight && attempt.state.flippedEdges == 0) closeHoles(attempt);
	if (!part("repair", 0.7)) return attempt;
	if (attempt.state.watertight) settle(attempt);
	attempt.mesh = withoutUnusedVertices(attempt.mesh);
	part("repair", 1);
	return attempt;
}

/// The manifold result if one policy gives it; otherwise the result with less volume in doubt.
Attempt closeUp(const Mesh& welded, Steps& steps)
{
	Attempt attempt = closeUp(welded, OppositePairs::KeepOne, steps, 0.4);
	if (!steps.goesOn() || attempt.isManifold()) return attempt;
	Attempt withoutWalls = closeUp(welded, OppositePairs::DropBoth, steps, 0.6);
	if (!withoutWalls.state.watertight || withoutWalls.mesh.triangles.empty()) return attempt;
	if (withoutWalls.contradicts != attempt.contradicts) return withoutWalls.contradicts ? attempt : withoutWalls;
	return withoutWalls.isManifold() || !attempt.state.watertight || withoutWalls.doubt < attempt.doubt ? withoutWalls : attempt;
}

/// Closes the surface downwards, and settles its shells.
Result<Attempt> closeGround(const Mesh& welded, const GroundClosing& ground)
{
	Attempt attempt = cleaned(welded, OppositePairs::KeepOne);
	const int64_t open = attempt.state.openEdges;
	const Result<bool> turned = closeDownwards(attempt.mesh, ground);
	if (!turned) return turned.error();
	if (turned.value()) attempt.actions.push_back("Turned the open surface, which faced down.");
	attempt.actions.push_back("Closed the surface downwards from " + counted(open, "open edge", "open edges") + ", to a bottom " +
		number(ground.depth) + " m below its lowest point.");
	attempt.state = closedness(attempt.mesh);
	if (attempt.state.watertight) settle(attempt);
	attempt.mesh = withoutUnusedVertices(attempt.mesh);
	return attempt;
}

/// Replaces the mesh by its wrap. Returns an error if that fails.
std::optional<Error> wrap(Attempt& attempt, const Progress& progress, int threads)
{
	Result<Mesh> wrapped = wrapSurface(attempt.mesh, kWrapCells, progress, threads);
	if (!wrapped) return wrapped.error();
	const double cell = bounds(attempt.mesh).longestSide() / kWrapCells;
	attempt.mesh = thinned(wrapped.value(), kThinning * cell, progress);
	// The two sides of the surface may each be off by half a cell.
	attempt.doubt += surfaceArea(attempt.mesh) * cell / 2;
	attempt.actions.push_back("Rebuilt the surface as " +
		counted(static_cast<int64_t>(attempt.mesh.triangles.size()), "triangle", "triangles") + " on a grid of " + number(cell) +
		" m; what is thinner may be lost, and the surface may lie up to " + number(cell * std::sqrt(3.0)) + " m off.");
	attempt.state = closedness(attempt.mesh);
	return std::nullopt;
}

/// The midpoint of the first edge that is not used equally often in both directions.
std::string firstBadEdge(const Mesh& mesh)
{
	std::optional<Vec3> found;
	forEachEdge(sortedEdges(mesh), [&](const EdgeUse* use, std::size_t count) {
		int64_t balance = 0;
		for (std::size_t i = 0; i < count; ++i) balance += use[i].forward ? 1 : -1;
		if (balance != 0 && !found) found = 0.5 * (mesh.vertices[use->low] + mesh.vertices[use->high]);
	});
	return found ? ", the first at " + place(*found) : "";
}

Error notClosed(const Mesh& mesh, const Closedness& found, const std::string& remedy)
{
	std::string list;
	const auto add = [&](int64_t count, const char* singular, const char* plural) {
		if (count) list += (list.empty() ? "" : ", ") + counted(count, singular, plural);
	};
	add(found.openEdges, "open edge", "open edges");
	add(found.nonManifoldEdges, "edge with more than two triangles", "edges with more than two triangles");
	add(found.flippedEdges, "edge between triangles that face opposite ways", "edges between triangles that face opposite ways");
	if (list.empty()) list = "no triangle with three different corners";
	return Error{"the mesh is not closed: " + list + firstBadEdge(mesh) + "; " + remedy};
}

Attempt prepareToWrap(const Mesh& welded)
{
	Attempt attempt = cleaned(welded, OppositePairs::KeepOne);
	if (attempt.state.watertight) settle(attempt);
	else if (massProperties(attempt.mesh).volume < 0)
	{
		for (Triangle& t : attempt.mesh.triangles) std::swap(t[1], t[2]);
		attempt.actions.push_back("Turned the surface inside out.");
	}
	attempt.mesh = withoutUnusedVertices(attempt.mesh);
	return attempt;
}

/// Replaces an attempt whose caps are not reliable by the region inside the open surface according to its winding number.
std::optional<Error> wrapOpen(Attempt& attempt, const Mesh& welded, Steps& steps, int threads)
{
	Attempt rebuilt = prepareToWrap(welded);
	const Error open = notClosed(rebuilt.mesh, rebuilt.state,
		"what is missing may be as much as the body; rebuild it on a grid (RepairMode::Wrap), which takes what it surrounds for the body, "
		"or close it in a modelling program and export it again");
	rebuilt.actions.push_back("Left " + counted(attempt.holes, "hole", "holes") + " open: closing them would have taken the body apart.");
	const auto refusal = [&] { return Error{open.message + groundAdvice(welded)}; };
	const OpenVolume found = openVolume(rebuilt.mesh, probesAlong(rebuilt.mesh));
	if (found.inside > 0 && found.ambiguous > kHopeless * found.inside) return refusal();
	rebuilt.doubt += found.ambiguous;
	if (auto error = wrap(rebuilt, steps.upTo(0.95), threads)) return error;
	if (rebuilt.doubt > massProperties(rebuilt.mesh).volume) return refusal();
	attempt = std::move(rebuilt);
	return std::nullopt;
}

/// Wraps a surface of which a share is counted wrongly. The wrap is dropped if it loses more than that, as with parts thinner than a
/// cell.
std::optional<Error> wrapCuts(Attempt& attempt, const std::string& found, double wrong, Steps& steps, int threads)
{
	if (std::isinf(wrong))
	{
		attempt.actions.push_back(
			"Left " + found + ": the body is too thin to rebuild its surface on a grid; what lies in two of its parts is counted twice.");
		return std::nullopt;
	}
	if (wrong > kHopelessCuts)
		return Error{"the mesh has " + found + ", and for them " + number(std::round(wrong)) +
			" times what it encloses is counted wrongly; rebuild it on a grid (RepairMode::Wrap), which takes what it surrounds for the "
			"body, or part it where it passes through itself in a modelling program"};
	Attempt rebuilt = attempt;
	rebuilt.actions.push_back("Found " + found + ".");
	if (auto error = wrap(rebuilt, steps.upTo(0.95), threads)) return error;
	const double inside = massProperties(attempt.mesh).volume / (1 + wrong);
	if (massProperties(rebuilt.mesh).volume >= (1 - std::min(wrong, kMostLost)) * inside)
	{
		attempt = std::move(rebuilt);
		return std::nullopt;
	}
	attempt.doubt += wrong * inside;
	attempt.actions.push_back("Left " + found + ": about " + number(std::round(1000 * wrong) / 10) +
		" % of what the surface encloses is counted wrongly for it, and rebuilding it on a grid would lose more.");
	return std::nullopt;
}

/// If the surface covers some places more than once, wraps it, unless that changes the volume by little or loses more than it corrects.
std::optional<Error> settleCuts(Attempt& attempt, const Mesh& welded, int64_t& cuts, Steps& steps, int threads)
{
	if (attempt.contradicts) return wrapOpen(attempt, welded, steps, threads);
	cuts = countCuts(attempt.mesh, kMostCuts, threads);
	if ((cuts == 0 && !attempt.mayOverlap) || !steps.reach(0.7)) return std::nullopt;
	const double wrong = miscountedShare(attempt.mesh, columnsAlong(attempt.mesh));
	// Shells may pass through one another without overlapping, like the links of a chain, or share a wall up to rounding.
	if (cuts == 0 && (wrong < kRounding || std::isinf(wrong))) return std::nullopt;
	const std::string found = cuts == 0 ? "shells that overlap"
										: (cuts == kMostCuts ? "at least " : "") +
			counted(cuts, "pair of triangles that cut each other", "pairs of triangles that cut each other");
	if (wrong <= kHarmless)
	{
		attempt.actions.push_back(
			"Left " + found + ": less than " + number(100 * kHarmless) + " % of what the surface encloses is counted wrongly for it.");
		return std::nullopt;
	}
	if (attempt.doubt > std::fabs(massProperties(attempt.mesh).volume)) return wrapOpen(attempt, welded, steps, threads);
	return wrapCuts(attempt, found, wrong, steps, threads);
}

/// Position of any corner of a triangle; empty if it has no valid corner.
std::string placeOfAnyCorner(const Mesh& mesh, const Triangle& t)
{
	for (const uint32_t corner : t)
		if (corner < mesh.vertices.size()) return ", which has a corner at " + place(mesh.vertices[corner]) + ",";
	return {};
}

std::optional<Error> whyUnreadable(const Mesh& mesh)
{
	if (mesh.triangles.empty()) return Error{"the mesh is empty: it has no triangles; give it a surface"};
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		if (!indicesAreValid(mesh, mesh.triangles[i]))
			return Error{"triangle " + std::to_string(i) + placeOfAnyCorner(mesh, mesh.triangles[i]) +
				" refers to a vertex that does not exist; export the mesh again"};
		for (const uint32_t corner : mesh.triangles[i])
			if (!isFinite(mesh.vertices[corner])) return Error{whereNotFinite(mesh) + "; export the mesh again"};
	}
	const double side = bounds(mesh).longestSide();
	if (side > 0 && (side < kShortestSide || !(side <= kLongestSide)))
		return Error{"the mesh is " + number(side) + " m long, " + extent(bounds(mesh)) + ", and a tree may be " + number(kShortestSide) +
			" to " + number(kLongestSide) + " m; pass its unit to importMesh(), or scale it"};
	return std::nullopt;
}

/// Notes shells that count twice or against each other, for a caller that chose to leave them.
void noteUnsettled(Attempt& attempt)
{
	Mesh settled = attempt.mesh;
	const ShellVerdict verdict = settleShells(settled);
	if (verdict.turned + verdict.dropped + verdict.redundant == 0) return;
	attempt.actions.push_back("Left shells as they face: the automatic repair would turn or drop some, and make the volume " +
		number(massProperties(settled).volume) + " m^3.");
}

/// Mode Off: welds only, which may collapse triangles.
Attempt asGiven(const Mesh& welded)
{
	Attempt attempt{welded, {}, {}, 0};
	attempt.note(dropCollapsed(attempt.mesh), "Dropped", "triangle with repeated corners", "triangles with repeated corners");
	attempt.mesh = withoutUnusedVertices(attempt.mesh);
	attempt.state = closedness(attempt.mesh);
	if (attempt.state.watertight && attempt.state.components > 1) noteUnsettled(attempt);
	return attempt;
}

/// The error for a mesh that encloses nothing. `found`: what was tried.
Error enclosesNothing(const Mesh& mesh, const std::string& found)
{
	if (enclosesInsideOut(mesh, probesAlong(mesh)))
		return Error{"the surface passes through itself " + extent(bounds(mesh)) +
			", so that as much of what it encloses is inside out as is not; "
			"part it where it crosses itself and turn what is inside out"};
	return Error{"the mesh is flat" + found + " " + extent(bounds(mesh)) + "; give it thickness" + groundAdvice(mesh)};
}

/// Moves the attempt into the result, unless it encloses nothing.
std::optional<Error> finish(Attempt& attempt, const Mesh& welded, RepairMode mode, RepairedMesh& result)
{
	const double side = bounds(attempt.mesh).longestSide();
	result.volumeAfter = massProperties(attempt.mesh).volume;
	if (!(std::fabs(result.volumeAfter) > kFlat * side * surfaceArea(attempt.mesh)))
		return enclosesNothing(welded, ": it encloses " + number(result.volumeAfter) + " m^3");
	if (result.volumeAfter < 0)
		return Error{"the mesh is inside out: its volume is " + number(result.volumeAfter) + " m^3 " + extent(bounds(attempt.mesh)) + "; " +
			(mode == RepairMode::Off ? "use the automatic repair or turn its triangles" : "turn its triangles")};
	result.mesh = std::move(attempt.mesh);
	result.volumeDoubt = attempt.doubt;
	result.actions = std::move(attempt.actions);
	const double change = result.volumeAfter - result.volumeBefore;
	if (mode != RepairMode::Ground && std::fabs(change) > 1e-9 * result.volumeAfter &&
		number(result.volumeBefore) != number(result.volumeAfter))
		result.actions.push_back("The volume changed from " + number(result.volumeBefore) + " to " + number(result.volumeAfter) + " m^3.");
	return std::nullopt;
}
}  // namespace

Closedness inspect(const Mesh& mesh)
{
	const auto isValid = [&](const Triangle& t) { return indicesAreValid(mesh, t); };
	if (std::all_of(mesh.triangles.begin(), mesh.triangles.end(), isValid)) return closedness(weldedEqual(mesh));
	Mesh readable = mesh;
	const auto dropped = std::erase_if(readable.triangles, [&](const Triangle& t) { return !isValid(t); });
	Closedness found = closedness(weldedEqual(readable));
	found.degenerateTriangles += static_cast<int64_t>(dropped);
	found.watertight = false;
	return found;
}

Result<RepairedMesh> repair(const Mesh& mesh, RepairMode mode, const Progress& progress, int threads, const GroundClosing& ground)
{
	const Error cancelled{"the repair was cancelled", true};
	Steps steps(progress);
	if (!steps.reach(0)) return cancelled;
	if (const auto error = whyUnreadable(mesh)) return *error;
	const Mesh welded = weldedEqual(mesh);
	if (!steps.reach(0.1)) return cancelled;
	RepairedMesh result;
	result.before = closedness(welded);
	result.volumeBefore = massProperties(mesh).volume;
	if (!steps.reach(0.2)) return cancelled;

	Result<Attempt> prepared = mode == RepairMode::Off ? asGiven(welded)
		: mode == RepairMode::Wrap                     ? prepareToWrap(welded)
		: mode == RepairMode::Ground                   ? closeGround(welded, ground)
													   : Result<Attempt>(closeUp(welded, steps));
	if (!prepared) return prepared.error();
	Attempt attempt = std::move(prepared).value();
	if (!steps.goesOn()) return cancelled;
	if (mode == RepairMode::Wrap)
	{
		if (const auto error = wrap(attempt, steps.upTo(0.95), threads)) return *error;
		if (attempt.mesh.triangles.empty())
			return enclosesNothing(
				welded, " or open: no point of a grid of " + number(bounds(welded).longestSide() / kWrapCells) + " m lies inside it");
	}
	if (!attempt.state.watertight)
		return notClosed(attempt.mesh, attempt.state,
			(mode == RepairMode::Off
					? "use the automatic repair"
					: "rebuild it on a grid (RepairMode::Wrap), which takes what it surrounds for the body, or close it in a "
					  "modelling program and export it again") +
				(mode == RepairMode::Ground ? "" : groundAdvice(welded)));
	if (mode == RepairMode::Auto || mode == RepairMode::Ground)
		if (const auto error = settleCuts(attempt, welded, result.cuts, steps, threads)) return *error;
	if (!steps.goesOn()) return cancelled;
	if (const auto error = finish(attempt, welded, mode, result)) return *error;
	if (welded.vertices.size() != mesh.vertices.size())
		result.actions.insert(result.actions.begin(),
			"Welded equal positions: " + std::to_string(mesh.vertices.size()) + " vertices became " +
				std::to_string(welded.vertices.size()) + ".");
	result.actions.insert(result.actions.begin(), mesh.notTaken.begin(), mesh.notTaken.end());
	if (!steps.reach(1)) return cancelled;
	return result;
}
}  // namespace ist
