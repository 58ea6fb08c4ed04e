// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/GraspObjects.h"

#include "BulletISTCollision/Core/Import/MeshFileVertices.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MatchingVertices.h"
#include "BulletISTCollision/Core/Mesh/MeshDivision.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "demos/scenes/Bodies/ImplicitMesh.h"
#include "demos/scenes/Grasp/Unwrap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kBunnySize = 0.09;
constexpr double kLoadedSize = 0.1, kLoadedEdge = 0.002, kLoadedMass = 0.15;     // size, edge and mass of meshes from files [m, m, kg]
constexpr double kHandBreadth = 0.07, kWidestGrip = 0.076, kLowestGrip = 0.014;  // [m]
constexpr const char* kBunny = "/usr/share/glmark2/models/bunny.obj";

/// Depth below the surface [m], positive inside; approximate for these shapes.
double roundBox(const Vec3& p, const Vec3& half, double rounding)
{
	const Vec3 q = Vec3{std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)} - half + Vec3{rounding, rounding, rounding};
	return rounding - norm(componentMax(q, {})) - std::min(std::max({q.x, q.y, q.z}), 0.0);
}
double ellipsoid(const Vec3& p, const Vec3& r)
{
	const Vec3 q{p.x / r.x, p.y / r.y, p.z / r.z}, g{q.x / r.x, q.y / r.y, q.z / r.z};
	const double k = norm(q), m = norm(g);
	return m > 0 ? -k * (k - 1) / m : std::min({r.x, r.y, r.z});
}
double torus(const Vec3& p, double ring, double tube) { return tube - std::hypot(std::hypot(p.x, p.z) - ring, p.y); }
/// A rounded wall about the y axis between two radii.
double tube(const Vec3& p, double inner, double outer, double lower, double upper, double rounding)
{
	const Vec3 q{std::hypot(p.x, p.z) - 0.5 * (inner + outer), p.y - 0.5 * (lower + upper), 0};
	return roundBox(q, {0.5 * (outer - inner), 0.5 * (upper - lower), 1}, rounding);
}
/// Union with a fillet of about this width.
double joined(double a, double b, double fillet)
{
	const double h = std::max(fillet - std::fabs(a - b), 0.0) / fillet;
	return std::max(a, b) + 0.25 * h * h * fillet;
}

constexpr double kMugRadius = 0.032, kArch = 0.022;
/// Position relative to the middle of the mug's handle, which is an upright arch.
Vec3 fromArch(const Vec3& p) { return p - Vec3{0.03, 0.043, 0}; }
double mug(const Vec3& p)
{
	const double wall = tube(p, 0.0275, kMugRadius, 0, 0.085, 0.002), floor = tube(p, -0.031, 0.031, 0, 0.006, 0.002);
	// The handle is cut off inside the wall.
	const Vec3 q = fromArch(p);
	const double handle = std::min(torus({q.x, q.z, q.y}, kArch, 0.0045), std::hypot(p.x, p.z) - 0.0285);
	return joined(joined(wall, floor, 0.003), handle, 0.004);
}
const TurnedHandle kMugHandle = {[](const Vec3& p) {
									 const Vec3 q = fromArch(p);
									 return std::hypot(p.x, p.z) > kMugRadius + 0.0015 &&
										 std::hypot(std::hypot(q.x, q.y) - kArch, q.z) < 0.009;
								 },
	[](const Vec3& p) { return std::atan2(fromArch(p).y, fromArch(p).x); },
	[](const Vec3& p) { return std::atan2(fromArch(p).z, std::hypot(fromArch(p).x, fromArch(p).y) - kArch); }};
double duck(const Vec3& p)
{
	const double body = ellipsoid(p - Vec3{0, 0.026, 0}, {0.046, 0.028, 0.031}),
				 tail = ellipsoid(p - Vec3{0.04, 0.04, 0}, {0.016, 0.012, 0.014});
	const double head = ellipsoid(p - Vec3{-0.024, 0.064, 0}, {0.021, 0.02, 0.019}),
				 beak = ellipsoid(p - Vec3{-0.046, 0.06, 0}, {0.014, 0.0055, 0.01});
	const double all = joined(joined(joined(body, tail, 0.012), head, 0.012), beak, 0.004);
	return std::min(all, p.y);  // flat base to stand on
}
double nut(const Vec3& p)
{
	double hexagon = 1;
	for (int i = 0; i < 3; ++i)
	{
		const double angle = i * 3.14159265358979323846 / 3;
		hexagon = std::min(hexagon, 0.025 - std::fabs(std::cos(angle) * p.z + std::sin(angle) * p.x));
	}
	// A cone cuts the corners off at both ends, as on turned nuts.
	const double r = std::hypot(p.x, p.z), edge = 0.015 + (0.0265 - r) / std::sqrt(3.0) - std::fabs(p.y - 0.015);
	// The thread has one start.
	const double pitch = 0.006, phase = std::atan2(p.z, p.x) / 6.28318530717958648 - p.y / pitch,
				 groove = std::fabs(phase - std::round(phase));
	return std::min({hexagon, 0.015 - std::fabs(p.y - 0.015), edge, 0.8 * (r - 0.0125 + 0.003 * groove)});
}
double plate(const Vec3& p) { return roundBox(p - Vec3{0, 0.03, 0}, {0.05, 0.03, 0.0025}, 0.001); }
double ring(const Vec3& p) { return tube(p, 0.024, 0.03, 0, 0.03, 0.0025); }

Result<Mesh> bunny()
{
	Result<Mesh> read = importMesh(kBunny);
	if (!read) return Error{read.error().message + "; the bunny comes with: apt-get install glmark2-data"};
	Mesh mesh = std::move(read).value();
	const Box box = bounds(mesh);
	const Vec3 foot{0.5 * (box.lower.x + box.upper.x), box.lower.y, 0.5 * (box.lower.z + box.upper.z)};
	for (Vec3& p : mesh.vertices) p = kBunnySize / box.longestSide() * (p - foot);
	Result<RepairedMesh> repaired = repair(mesh, RepairMode::Auto, {});
	if (!repaired) return repaired.error();
	return std::move(repaired).value().mesh;
}

/// Where a hand grips a body that stands on its lowest point: across z at the height of its centre of mass.
struct Grip
{
	Vec3 foot;                          ///< below the centre of mass, at the height of the lowest point
	double height = 0;                  ///< above the foot [m]
	double low = 1e300, high = -1e300;  ///< extent along z of the section at that height, within a hand's breadth of the middle [m]
	double width() const { return std::max(high - low, 0.0); }

	/// Extends it by the part of a segment that lies within a hand's breadth of x = 0.
	void reach(Vec3 a, Vec3 b)
	{
		if (a.x > b.x) std::swap(a, b);
		constexpr double kAside = kHandBreadth / 2;
		if (a.x > kAside || b.x < -kAside) return;
		const double along = b.x - a.x;
		for (const double share :
			{along > 0 ? std::max((-kAside - a.x) / along, 0.0) : 0, along > 0 ? std::min((kAside - a.x) / along, 1.0) : 1})
		{
			const double z = a.z + share * (b.z - a.z);
			low = std::min(low, z);
			high = std::max(high, z);
		}
	}
};
Grip gripOf(const Mesh& mesh)
{
	const Vec3 middle = massProperties(mesh).centerOfMass;
	Grip grip;
	grip.foot = {middle.x, bounds(mesh).lower.y, middle.z};
	grip.height = std::max(middle.y - grip.foot.y, kLowestGrip);
	const double y = grip.foot.y + grip.height;
	for (const auto& t : mesh.triangles)
	{
		std::array<Vec3, 2> ends;
		size_t count = 0;
		for (size_t c = 0; c < 3; ++c)
		{
			const Vec3 &a = mesh.vertices[t[c]], &b = mesh.vertices[t[(c + 1) % 3]];
			if ((a.y > y) != (b.y > y)) ends[count++] = a + (y - a.y) / (b.y - a.y) * (b - a) - Vec3{middle.x, 0, 0};
		}
		if (count == 2) grip.reach(ends[0], ends[1]);
	}
	return grip;
}

std::string millimetres(double metres) { return std::to_string(std::lround(1e3 * metres)) + " mm"; }

/// "turn it (--up z makes it 58 mm wide there), or ": the axes of the file that, turned up, make it narrow enough. `mesh`: turned by `up`.
std::string narrowerTurns(const Mesh& mesh, const std::optional<UpAxes>& up)
{
	const Mesh file = up ? turnedUp(mesh, up->to, up->from) : mesh;
	std::string turns;
	for (const SignedAxis axis : {SignedAxis{1, 1}, SignedAxis{2, 1}, SignedAxis{0, 1}})
		if (const double width = gripOf(turnedUp(file, axis, {1, 1})).width(); width > 0 && width <= kWidestGrip)
			turns += (turns.empty() ? "" : ", ") + std::string("--up ") + axisName(axis) + " makes it " + millimetres(width) +
				" wide there";
	return turns.empty() ? "" : "turn it (" + turns + "), or ";
}

/// Reads the surface of a file, with texture coordinates if it contains some.
Result<TexturedMesh> readSurface(const std::string& path, const std::optional<double>& unit)
{
	Result<TexturedMesh> textured = importTexturedMesh(path, unit);
	if (textured) return textured;
	Result<Mesh> bare = importMesh(path, unit);
	if (!bare) return bare.error();
	return TexturedMesh{std::move(bare).value(), {}};
}

struct Row
{
	GraspObject object;
	double (*field)(const Vec3&);  // null: the object comes from a file
	Box box;
	double cell;
};
const std::vector<Row>& rows()
{
	static const std::vector<Row> all = {
		{{"mug", {}, 0.18, 0.05, 0, 0, 0.064, {}}, mug, {{-0.037, -0.005, -0.037}, {0.063, 0.09, 0.037}}, 0.0016},
		{{"bunny", {}, 0.15, 0.019, 0, 0.006, 0.056, {}}, nullptr, {}, 0},
		{{"duck", {}, 0.12, 0.016, 0, 0, 0.062, {}}, duck, {{-0.067, -0.006, -0.038}, {0.063, 0.092, 0.038}}, 0.002},
		{{"nut", {}, 0.2, 0.014, 0, 0, 0.05, {}}, nut, {{-0.036, -0.006, -0.032}, {0.036, 0.036, 0.032}}, 0.0012},
		{{"plate", {}, 0.08, 0.04, 0, 0, 0.005, {}}, plate, {{-0.056, -0.006, -0.0085}, {0.056, 0.066, 0.0085}}, 0.0011},
		{{"ring", {}, 0.1, 0.016, 0, 0, 0.06, {}}, ring, {{-0.036, -0.006, -0.036}, {0.036, 0.036, 0.036}}, 0.0016}};
	return all;
}
}  // namespace

const std::vector<std::string>& graspObjectNames()
{
	static const std::vector<std::string> names = [] {
		std::vector<std::string> all;
		for (const Row& row : rows()) all.push_back(row.object.name);
		return all;
	}();
	return names;
}

Result<GraspObject> makeGraspObject(const std::string& name)
{
	for (const Row& row : rows())
	{
		if (row.object.name != name) continue;
		GraspObject object = row.object;
		if (row.field)
		{
			object.mesh = meshOfField(row.field, row.box, row.cell);
			if (row.field == mug) object.texture = unwrapTurned(object.mesh, &kMugHandle);
			if (row.field == ring) object.texture = unwrapTurned(object.mesh);
			return object;
		}
		Result<Mesh> mesh = bunny();
		if (!mesh) return mesh.error();
		object.mesh = std::move(mesh).value();
		return object;
	}
	std::string known;
	for (const std::string& other : graspObjectNames()) known += (known.empty() ? "" : ", ") + other;
	return Error{"nothing to grasp is called " + name + ": there are " + known};
}

Result<GraspObject> loadGraspObject(const std::string& path, const GraspFile& file)
{
	Result<TexturedMesh> read = readSurface(path, file.unit > 0 ? std::optional(file.unit) : std::nullopt);
	if (!read) return read.error();
	TexturedMesh surface = std::move(read).value();
	const double scale = file.unit > 0 ? 1 : kLoadedSize / bounds(surface.mesh).longestSide();
	for (Vec3& p : surface.mesh.vertices) p = scale * p;
	surface.mesh = turnedUp(std::move(surface.mesh), file.up);
	const Result<RepairedMesh> repaired = repair(surface.mesh);
	if (!repaired) return Error{path + ": " + repaired.error().message};
	const Mesh& mesh = repaired.value().mesh;
	const Grip grip = gripOf(mesh);
	if (!(grip.width() > 0))
		return Error{path + ": there is nothing between thumb and fingers at the height of " + millimetres(grip.height) + ": " +
			narrowerTurns(mesh, file.up) + "give another --unit"};
	if (grip.width() > kWidestGrip)
		return Error{path + ": it is " + millimetres(grip.width()) + " wide along z where it would be gripped, and the hand opens to " +
			millimetres(kWidestGrip) + ": " + narrowerTurns(mesh, file.up) + "give another --unit"};
	GraspObject object;
	object.name = std::filesystem::path(path).stem().string();
	object.mesh = dividedMesh(translated(mesh, -grip.foot), kLoadedEdge);
	if (!surface.places.empty()) object.texture = {translated(surface.mesh, -grip.foot), std::move(surface.places)};
	Result<std::vector<Vec3>> vertices = importVertices(path, file.unit > 0 ? std::optional(file.unit) : std::nullopt);
	if (!vertices) return vertices.error();
	Mesh points{std::move(vertices).value(), {}};
	for (Vec3& p : points.vertices) p = scale * p;
	points = translated(turnedUp(std::move(points), file.up), -grip.foot);
	const std::vector<int64_t> matching = matchingVertices(points.vertices, object.mesh, weldingTolerance(object.mesh));
	// A mesh that was rebuilt on a grid has no vertices of the file.
	if (std::any_of(matching.begin(), matching.end(), [](int64_t vertex) { return vertex >= 0; })) object.fileVertices = points.vertices;
	object.mass = file.mass > 0 ? file.mass : kLoadedMass;
	object.gripHeight = grip.height;
	object.width = grip.width();
	object.gripZ = 0.5 * (grip.low + grip.high) - grip.foot.z;
	return object;
}
}  // namespace scenes
