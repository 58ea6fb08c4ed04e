// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Repair/MeshGround.h"

#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Core/Mesh/MeshEdges.h"
#include "BulletISTCollision/Core/Repair/MeshHoles.h"
#include "BulletISTCollision/Core/Repair/MeshOrientation.h"
#include "BulletISTCollision/Core/Repair/MeshProbes.h"
#include "BulletISTCollision/Core/Repair/MeshWeld.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

namespace ist
{
namespace
{
constexpr std::string_view kGround = "ground ";
/// Least Facing::up of ground that is closed: overhangs may have a third of the area of the floor.
constexpr double kFacesUp = 0.5;
/// Least Facing::up of a mesh that is called ground.
constexpr double kIsGround = 0.95;
/// Least Facing::flat of a mesh that is called ground, and of ground that is closed.
constexpr double kMostlyFlat = 0.5, kNotWalls = 1e-3;
/// Largest Facing::against of ground: scraps of a scan may face the other way.
constexpr double kMostAgainst = 1e-3;
/// Largest share of the volume that closed parts may fill twice, and number of lines along the longest side that measure it.
constexpr double kMostTwice = 0.01;
/// Share of what lies under ground, down to its lowest point, that a flat lid over its edge may enclose: half a ball has 2/3. Open
/// containers have more.
constexpr double kContainer = 0.75;
constexpr int kLines = 256;

/// Twice the area of a triangle, projected along an axis; negative if the triangle faces against it.
double projected(const Mesh& mesh, const Triangle& t, SignedAxis axis)
{
	const Vec3& a = mesh.vertices[t[0]];
	return axis.sign * cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a)[axis.axis];
}

/// The connected parts of a surface that have an open edge. Turning triangles changes nothing of it.
struct OpenParts
{
	std::vector<uint32_t> component;  ///< of each triangle
	std::vector<uint8_t> isOpen;      ///< for each triangle, whether its part has an open edge

	explicit OpenParts(const Mesh& mesh) : isOpen(mesh.triangles.size(), 0)
	{
		const std::vector<EdgeUse> edges = sortedEdges(mesh);
		component = componentOfTriangle(mesh, edges);
		forEachEdge(edges, [&](const EdgeUse* use, std::size_t count) {
			if (count == 1) isOpen[component[use->triangle]] = 1;
		});
		for (std::size_t i = 0; i < isOpen.size(); ++i) isOpen[i] = isOpen[component[i]];
	}
};

/// Which way the open parts of a surface face.
struct Facing
{
	/// Net areas of the parts over the sum of areas, both projected: 1 if each part faces up or down everywhere, 0 for surfaces that
	/// enclose.
	double up = 0;
	double flat = 0;      ///< projected area over area: 1 for a plane across the axis, 0 for walls along it
	double against = 0;   ///< net area of the parts that face the other way than most, over the sum of areas, both projected
	bool isDown = false;  ///< whether most face down

	Facing(const Mesh& mesh, const OpenParts& parts, SignedAxis axis)
	{
		std::vector<double> net(mesh.triangles.size(), 0);
		double total = 0, area = 0;
		for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
		{
			if (!parts.isOpen[i]) continue;
			const Triangle& t = mesh.triangles[i];
			const double across = projected(mesh, t, axis);
			net[parts.component[i]] += across;
			total += std::fabs(across);
			area += norm(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
		}
		if (!(total > 0)) return;
		double upwards = 0, downwards = 0;
		for (const double n : net) (n < 0 ? downwards : upwards) += std::fabs(n);
		up = (upwards + downwards) / total;
		flat = total / area;
		against = std::min(upwards, downwards) / total;
		isDown = downwards > upwards;
	}
};

void addBottomAndWalls(Mesh& mesh, const GroundClosing& ground, const std::vector<EdgeUse>& edges)
{
	const Box box = bounds(mesh);
	const int axis = ground.up.axis;
	const double bottom = ground.up.sign > 0 ? box.lower[axis] - ground.depth : box.upper[axis] + ground.depth;
	const auto below = [n = static_cast<uint32_t>(mesh.vertices.size())](uint32_t v) { return v + n; };
	const std::size_t triangles = mesh.triangles.size(), vertices = mesh.vertices.size();
	for (std::size_t i = 0; i < vertices; ++i)
	{
		Vec3 v = mesh.vertices[i];
		v[axis] = bottom;
		mesh.vertices.push_back(v);
	}
	for (std::size_t i = 0; i < triangles; ++i)
	{
		const Triangle t = mesh.triangles[i];
		mesh.triangles.push_back({below(t[0]), below(t[2]), below(t[1])});
	}
	const auto wall = [&](uint32_t from, uint32_t to) {
		mesh.triangles.push_back({to, from, below(from)});
		mesh.triangles.push_back({to, below(from), below(to)});
	};
	forEachEdge(edges, [&](const EdgeUse* use, std::size_t count) {
		int64_t balance = 0;
		for (std::size_t i = 0; i < count; ++i) balance += use[i].forward ? 1 : -1;
		for (; balance > 0; --balance) wall(use->low, use->high);
		for (; balance < 0; ++balance) wall(use->high, use->low);
	});
}

/// Whether the open mesh is a container without its lid that faces outwards, such as a cover or half a housing, rather than ground. A room
/// without a ceiling faces inwards.
bool isContainer(const Mesh& mesh, SignedAxis facing)
{
	Mesh oriented = weldedEqual(mesh);
	orientConsistently(oriented);
	double area = 0;
	for (const Triangle& t : oriented.triangles) area += std::fabs(projected(oriented, t, facing)) / 2;
	closeHoles(oriented);
	return massProperties(oriented).volume > kContainer * area * bounds(oriented).size()[facing.axis];
}

std::string percent(double share) { return number(std::round(100 * share)) + " %"; }

std::optional<Error> whyUnusable(const GroundClosing& ground)
{
	if (!(ground.depth > 0) || !std::isfinite(ground.depth))
		return Error{"the depth to which ground is closed must be a positive number of metres, not " + number(ground.depth)};
	const auto [axis, sign] = ground.up;
	if (axis < 0 || axis > 2 || (sign != 1 && sign != -1))
		return Error{"the axis along which ground faces up must be 0, 1 or 2 with the sign 1 or -1, not " + std::to_string(axis) +
			" with " + std::to_string(sign)};
	return std::nullopt;
}

std::optional<Error> whyNotGround(const Mesh& mesh, const Facing& facing, SignedAxis up)
{
	if (!(facing.up >= kFacesUp && facing.flat >= kNotWalls))
	{
		const std::optional<SignedAxis> other = facingOfGround(mesh);
		return Error{"the open surface does not face " + axisName(up) + ", so that it cannot be closed downwards from there" +
			(other ? "; it faces " + axisName(*other) + ": name that axis as up" : "; give the mesh an inside in a modelling program")};
	}
	if (facing.against > kMostAgainst)
		return Error{"parts with " + percent(facing.against) + " of the open surface's area face against " + axisName(up) +
			", as ceilings do, and closing them downwards would fill the room below; turn them if they are ground, or give them thickness"};
	return std::nullopt;
}
}  // namespace

std::string groundText(const GroundClosing& ground)
{
	char depth[40];
	const size_t length = size_t(std::to_chars(depth, depth + sizeof depth, ground.depth).ptr - depth);
	return std::string(kGround).append(depth, length) + " " + axisName(ground.up);
}

std::optional<GroundClosing> groundFromText(std::string_view text)
{
	if (!text.starts_with(kGround)) return std::nullopt;
	text.remove_prefix(kGround.size());
	GroundClosing ground;
	const char* const last = text.data() + text.size();
	const auto [end, error] = std::from_chars(text.data(), last, ground.depth);
	if (error != std::errc() || !(ground.depth > 0) || !std::isfinite(ground.depth)) return std::nullopt;
	if (end == last) return ground;
	const std::optional<SignedAxis> up = *end == ' ' ? signedAxis({end + 1, size_t(last - end - 1)}) : std::nullopt;
	if (!up) return std::nullopt;
	ground.up = *up;
	return ground;
}

Result<bool> closeDownwards(Mesh& mesh, const GroundClosing& ground)
{
	if (const auto error = whyUnusable(ground)) return *error;
	if (verticesOfOpenEdges(mesh).empty())
		return Error{"no edge of the mesh is open, so that there is nothing to close downwards; use the automatic repair"};
	const OpenParts parts(mesh);
	const Facing facing(mesh, parts, ground.up);
	if (const auto error = whyNotGround(mesh, facing, ground.up)) return *error;
	// Only parts with open edges get a bottom: the others are bodies that lie on the ground or in it.
	Mesh open{mesh.vertices, {}, mesh.rounding}, closed = open;
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i) (parts.isOpen[i] ? open : closed).triangles.push_back(mesh.triangles[i]);
	for (Triangle& t : open.triangles)
		if (facing.isDown) std::swap(t[1], t[2]);
	open = withoutUnusedVertices(open);
	addBottomAndWalls(open, ground, sortedEdges(open));
	if (const double twice = miscountedShare(open, kLines); twice > kMostTwice && !std::isinf(twice))
		return Error{"parts of the open surface lie over one another, so that closing them downwards fills " + percent(twice) +
			" of the volume twice; join them to one surface, or give the upper ones a lower side"};
	const auto first = static_cast<uint32_t>(open.vertices.size());
	closed = withoutUnusedVertices(closed);
	open.vertices.insert(open.vertices.end(), closed.vertices.begin(), closed.vertices.end());
	for (const Triangle& t : closed.triangles) open.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
	mesh.vertices = std::move(open.vertices);
	mesh.triangles = std::move(open.triangles);
	return facing.isDown;
}

std::optional<SignedAxis> facingOfGround(const Mesh& mesh)
{
	Mesh oriented = weldedEqual(mesh);
	if (verticesOfOpenEdges(oriented).empty()) return std::nullopt;
	orientConsistently(oriented);
	const OpenParts parts(oriented);
	for (const int axis : {1, 2, 0})
	{
		const Facing faces(oriented, parts, {axis, 1});
		if (faces.up >= kIsGround && faces.flat >= kMostlyFlat && faces.against <= kMostAgainst) return SignedAxis{axis, 1};
	}
	return std::nullopt;
}

std::string groundAdvice(const Mesh& mesh)
{
	const std::optional<SignedAxis> facing = facingOfGround(mesh);
	return facing && !isContainer(mesh, *facing)
		? "; if it is ground that faces " + axisName(*facing) + ", close it downwards along that axis (RepairMode::Ground)"
		: "";
}
}  // namespace ist
