// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/HeatMap.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr double kFacing = 0.7;  // cosine above which the nearest side counts as the one below the vertex
constexpr int kMostSteps = 8;
constexpr int kCellsAcross = 48;  // number of cells of the vertex grid along the longest side

struct Clipped
{
	double area = 0, sum = 0;
};

/// Area of the part of a triangle where the distance `d` is positive, and the thickness `t` of the other body integrated over it. `d` is
/// linear and positive inside. `facing` is the cosine between the inward direction here and the normal of the other body's nearest side. If
/// the outside corners show that the body tapers off, the thickness ends with the distance. If its side stands upright, the thickness
/// continues to the edge.
Clipped clip(double area, const double d[3], const double t[3], const double facing[3])
{
	const int inside = (d[0] > 0) + (d[1] > 0) + (d[2] > 0);
	if (inside == 0) return {};
	if (inside == 3) return {area, area * (t[0] + t[1] + t[2]) / 3};
	// The triangle that is cut off at the single corner on its side of the edge.
	int lone = 0;
	while ((d[lone] > 0) != (inside == 1)) ++lone;
	const double a = d[lone], b = d[(lone + 1) % 3], c = d[(lone + 2) % 3];
	const double corner = area * a / (a - b) * (a / (a - c)), cornerSum = corner * a / 3;
	const double kept = inside == 1 ? corner : area - corner, distances = inside == 1 ? cornerSum : area * (a + b + c) / 3 - cornerSum;
	double distance = 0, thickness = 0, faces = 0;
	for (int i = 0; i < 3; ++i)
	{
		if (d[i] > 0) distance += d[i], thickness += t[i];
		else faces += facing[i] / (3 - inside);
	}
	const double taper = std::clamp((faces - 0.5 * kFacing) / (0.5 * kFacing), 0.0, 1.0);
	return {kept, taper * distances * thickness / distance + (1 - taper) * kept * thickness / inside};
}
/// The number of grasps in which each vertex was touched.
struct GraspCount
{
	std::vector<int> count, last;

	explicit GraspCount(size_t vertices) : count(vertices), last(vertices) {}
	void add(uint32_t vertex, int grasp)
	{
		if (last[vertex] == grasp) return;
		last[vertex] = grasp;
		++count[vertex];
	}
};
}  // namespace

struct HeatMap::Part
{
	/// A point, and its distance from the surface.
	struct Near
	{
		Vec3 point;
		double distance = std::numeric_limits<double>::infinity();
		bool outside = false;
		/// Whether this proves that `p` is outside, too.
		bool provesOutside(const Vec3& p) const { return outside && ist::distance(p, point) < (1 - 1e-6) * distance; }
	};

	std::string name;
	int id = 0;
	MeshDistance distance;
	std::vector<Vec3> normals;  // normals of the triangles
	Box box;
	std::vector<double> dwell, impulse;  // sums per vertex
	std::vector<float> peak;
	GraspCount graspsAt;
	int grasps = 0, lastGrasp = 0;
	double seconds = 0, forceSum = 0, peakForce = 0, depth = 0;

	Part(const std::string& n, int i, Mesh mesh, size_t vertices)
		: name(n),
		  id(i),
		  distance(std::move(mesh)),
		  box(bounds(distance.mesh())),
		  dwell(vertices),
		  impulse(vertices),
		  peak(vertices),
		  graspsAt(vertices)
	{
		const Mesh& m = distance.mesh();
		for (const auto& t : m.triangles)
			normals.push_back(normalized(cross(m.vertices[t[1]] - m.vertices[t[0]], m.vertices[t[2]] - m.vertices[t[0]])));
	}

	/// As MeshDistance::field, but the winding number is computed only if the nearest triangle does not decide the side. `near` is the
	/// point and distance of the last query. The new distance is at most the old one plus the distance between the points.
	MeshDistance::Field field(const Vec3& p, Near& near) const
	{
		constexpr double kSlack = 1 + 1e-6;  // allowance for rounding
		MeshDistance::Closest closest = distance.closest(p, kSlack * (near.distance + ist::distance(p, near.point)));
		if (closest.triangle >= normals.size()) closest = distance.closest(p);
		const Vec3& face = normals[closest.triangle];
		const double lean = dot(p - closest.point, face);
		const bool inside = std::fabs(lean) > kFacing * closest.distance ? lean < 0 : distance.contains(p);
		near = {p, closest.distance, !inside};
		const Vec3 out = inside ? closest.point - p : p - closest.point;
		return {inside ? closest.distance : -closest.distance, closest.distance > 0 ? out / closest.distance : face};
	}
};

/// The object's mesh, its vertices sorted into a grid, and the state of the contact in progress.
struct HeatMap::Surface
{
	MeshDistance distance;
	std::vector<double> vertexArea, triangleArea;
	std::vector<Vec3> vertexNormals;                  // unit normals per vertex
	std::vector<uint32_t> firstTriangle, triangleOf;  // triangles of each vertex
	Box box;
	double cell = 1;
	size_t n[3] = {1, 1, 1};
	std::vector<uint32_t> firstVertex, vertexOf;  // vertices of each cell
	// State of the contact in progress.
	std::vector<uint32_t> stamp;
	std::vector<double> distanceIn, thickness, facing, share;
	std::vector<uint32_t> touched;
	uint32_t now = 0;
	Pose X_PO;
	Part* part = nullptr;  // null: none in progress
	HeatMapContact contact;
	Part::Near near;
	size_t from[3] = {}, to[3] = {};  // cells that the part's box touches
	size_t row = 0, vertex = 0;       // row of these cells along x, and vertex in it, at which collecting continues
	bool collected = false;
	size_t cutUntil = 0;       // number of entries of `touched` that are done
	double area = 0, sum = 0;  // area of the surface inside the part, and the thickness integrated over it
	int budgetLeft = 0;

	GraspCount graspsAt;  // grasps with any part

	explicit Surface(Mesh mesh) : distance(std::move(mesh)), graspsAt(distance.mesh().vertices.size())
	{
		const Mesh& m = distance.mesh();
		vertexArea.resize(m.vertices.size());
		stamp.resize(m.vertices.size());
		distanceIn.resize(m.vertices.size());
		thickness.resize(m.vertices.size());
		facing.resize(m.vertices.size());
		share.resize(m.vertices.size());
		touched.reserve(m.vertices.size());
		measureTriangles();
		sortIntoCells();
	}
	void measureTriangles()
	{
		const Mesh& m = distance.mesh();
		firstTriangle.assign(m.vertices.size() + 1, 0);
		vertexNormals.resize(m.vertices.size());
		for (const auto& t : m.triangles)
		{
			const Vec3 twice = cross(m.vertices[t[1]] - m.vertices[t[0]], m.vertices[t[2]] - m.vertices[t[0]]);
			triangleArea.push_back(0.5 * norm(twice));
			for (const uint32_t v : t)
			{
				vertexArea[v] += triangleArea.back() / 3;
				vertexNormals[v] += twice;
				++firstTriangle[v + 1];
			}
		}
		for (size_t v = 0; v < m.vertices.size(); ++v)
		{
			firstTriangle[v + 1] += firstTriangle[v];
			vertexNormals[v] = normalized(vertexNormals[v]);
		}
		triangleOf.resize(3 * m.triangles.size());
		std::vector<uint32_t> next = firstTriangle;
		for (uint32_t t = 0; t < m.triangles.size(); ++t)
			for (const uint32_t v : m.triangles[t]) triangleOf[next[v]++] = t;
	}
	/// Pressure of a force that acts on this vertex alone; 0 for a vertex without area.
	double pressureOf(double force, uint32_t v) const { return vertexArea[v] > 0 ? force / vertexArea[v] : 0; }
	size_t cellOf(const Vec3& p) const
	{
		size_t index = 0;
		for (int a = 2; a >= 0; --a) index = index * n[a] + place(p[a], a);
		return index;
	}
	size_t place(double x, int axis) const
	{
		const double i = (x - box.lower[axis]) / cell;
		return i > 0 ? std::min(size_t(i), n[axis] - 1) : 0;
	}
	void sortIntoCells()
	{
		const Mesh& m = distance.mesh();
		box = bounds(m);
		cell = std::max(box.longestSide() / kCellsAcross, 1e-12);
		for (int a = 0; a < 3; ++a) n[a] = size_t(box.size()[a] / cell) + 1;
		firstVertex.assign(n[0] * n[1] * n[2] + 1, 0);
		for (const Vec3& p : m.vertices) ++firstVertex[cellOf(p) + 1];
		for (size_t c = 0; c + 1 < firstVertex.size(); ++c) firstVertex[c + 1] += firstVertex[c];
		vertexOf.resize(m.vertices.size());
		std::vector<uint32_t> next = firstVertex;
		for (uint32_t v = 0; v < m.vertices.size(); ++v) vertexOf[next[cellOf(m.vertices[v])]++] = v;
	}
};

HeatMap::HeatMap(Mesh object) : m_surface(std::make_unique<Surface>(std::move(object))) {}
HeatMap::~HeatMap() = default;

int HeatMap::addPart(const std::string& name, int id, Mesh mesh)
{
	m_parts.push_back(std::make_unique<Part>(name, id, std::move(mesh), this->mesh().vertices.size()));
	return parts() - 1;
}

void HeatMap::beginGrasp() { ++m_grasps; }
const Mesh& HeatMap::mesh() const { return m_surface->distance.mesh(); }
int HeatMap::parts() const { return int(m_parts.size()); }
const std::string& HeatMap::partName(int part) const { return m_parts[size_t(part)]->name; }
int HeatMap::partId(int part) const { return m_parts[size_t(part)]->id; }

/// Stores the part's thickness below a vertex, along the normal of the object. Returns the depth of the vertex inside the part [m],
/// negative outside.
double HeatMap::depthOf(uint32_t vertex) noexcept
{
	Surface& s = *m_surface;
	if (s.stamp[vertex] == s.now) return s.distanceIn[vertex];
	s.stamp[vertex] = s.now;
	s.share[vertex] = s.thickness[vertex] = 0;
	Vec3 p = s.X_PO * mesh().vertices[vertex];
	const Vec3 inward = -(s.X_PO.rotation * s.vertexNormals[vertex]);
	MeshDistance::Field field = s.part->field(p, s.near);
	--s.budgetLeft;
	s.distanceIn[vertex] = field.depth;
	s.facing[vertex] = dot(field.normal, inward);
	for (int i = 0; i < kMostSteps && field.depth > 0; ++i)
	{
		const double facing = dot(field.normal, inward);
		// If the nearest side is not the one below, no side is nearer than this, so the step stays inside.
		s.thickness[vertex] += facing > kFacing ? field.depth / facing : field.depth;
		if (facing > kFacing || i + 1 == kMostSteps) break;
		p += field.depth * inward;
		field = s.part->field(p, s.near);
		--s.budgetLeft;
	}
	return s.distanceIn[vertex];
}

/// Computes the range of cells to search.
void HeatMap::beginCollecting(const Part& part) noexcept
{
	Surface& s = *m_surface;
	s.touched.clear();
	s.row = s.vertex = 0;
	s.collected = false;
	// The part's box in the object's frame.
	const Pose X_OP = inverse(s.X_PO);
	const Vec3 centre = X_OP * (0.5 * (part.box.lower + part.box.upper)), half = 0.5 * part.box.size();
	for (int a = 0; a < 3; ++a)
	{
		const Vec3 row = X_OP.rotation.row(a);
		const double reach = std::fabs(row.x) * half.x + std::fabs(row.y) * half.y + std::fabs(row.z) * half.z;
		s.collected = s.collected || centre[a] + reach < s.box.lower[a] || centre[a] - reach > s.box.upper[a];
		s.from[a] = s.place(centre[a] - reach, a);
		s.to[a] = s.place(centre[a] + reach, a);
	}
}

/// Collects the vertices inside the part while queries are left. Returns true if all are found.
bool HeatMap::collect(const Part& part) noexcept
{
	Surface& s = *m_surface;
	const size_t rows = s.collected ? 0 : (s.to[1] - s.from[1] + 1) * (s.to[2] - s.from[2] + 1);
	for (; s.row < rows; ++s.row, s.vertex = 0)
	{
		const size_t y = s.from[1] + s.row % (s.to[1] - s.from[1] + 1), z = s.from[2] + s.row / (s.to[1] - s.from[1] + 1);
		const size_t line = (z * s.n[1] + y) * s.n[0], first = s.firstVertex[line + s.from[0]], end = s.firstVertex[line + s.to[0] + 1];
		for (; first + s.vertex < end; ++s.vertex)
		{
			if (s.budgetLeft <= 0) return false;
			const uint32_t v = s.vertexOf[first + s.vertex];
			const Vec3 p = s.X_PO * mesh().vertices[v];
			if (p.x < part.box.lower.x || p.y < part.box.lower.y || p.z < part.box.lower.z || p.x > part.box.upper.x ||
				p.y > part.box.upper.y || p.z > part.box.upper.z)
				continue;
			if (!s.near.provesOutside(p) && depthOf(v) > 0) s.touched.push_back(v);
		}
	}
	return s.collected = true;
}

/// Clips every triangle at a touched vertex once, and sums each corner's share of the depth. Returns true if all are done.
bool HeatMap::cut() noexcept
{
	Surface& s = *m_surface;
	for (; s.cutUntil < s.touched.size(); ++s.cutUntil)
	{
		if (s.budgetLeft <= 0) return false;
		const uint32_t v = s.touched[s.cutUntil];
		for (uint32_t i = s.firstTriangle[v]; i < s.firstTriangle[v + 1]; ++i)
		{
			const uint32_t t = s.triangleOf[i];
			const auto& corners = mesh().triangles[t];
			const double d[3] = {depthOf(corners[0]), depthOf(corners[1]), depthOf(corners[2])};
			const uint32_t* first = std::find_if(corners.begin(), corners.end(), [&](uint32_t c) { return s.distanceIn[c] > 0; });
			if (*first != v) continue;
			const double thick[3] = {s.thickness[corners[0]], s.thickness[corners[1]], s.thickness[corners[2]]},
						 facing[3] = {s.facing[corners[0]], s.facing[corners[1]], s.facing[corners[2]]};
			const Clipped part = clip(s.triangleArea[t], d, thick, facing);
			s.area += part.area;
			s.sum += part.sum;
			const double inside = thick[0] + thick[1] + thick[2];
			for (int c = 0; c < 3; ++c)
				if (d[c] > 0) s.share[corners[size_t(c)]] += part.sum * thick[c] / inside;
		}
	}
	return true;
}

void HeatMap::enter(Part& part, uint32_t v, double force, double pressure, double seconds, HeatMapTouch& touch) noexcept
{
	Surface& s = *m_surface;
	part.dwell[v] += seconds;
	part.impulse[v] += force * seconds;
	part.peak[v] = std::max(part.peak[v], float(pressure));
	part.graspsAt.add(v, m_grasps);
	s.graspsAt.add(v, m_grasps);
	touch.depth = std::max(touch.depth, s.thickness[v]);
	touch.pressure = std::max(touch.pressure, pressure);
}

void HeatMap::enterArea(Part& part, const HeatMapContact& contact, double scale, HeatMapTouch& touch) noexcept
{
	const Surface& s = *m_surface;
	for (const uint32_t v : s.touched)
		enter(part, v, scale * s.share[v], std::min(scale * s.thickness[v], s.pressureOf(contact.force, v)), contact.seconds, touch);
}

/// Assigns a contact between the vertices completely to the nearest vertex.
void HeatMap::enterPoint(Part& part, const HeatMapContact& contact, HeatMapTouch& touch) noexcept
{
	Surface& s = *m_surface;
	const MeshDistance::Closest closest = s.distance.closest(contact.point);
	const auto& corners = mesh().triangles[closest.triangle];
	const uint32_t v = *std::min_element(corners.begin(), corners.end(),
		[&](uint32_t a, uint32_t b) { return distance(mesh().vertices[a], closest.point) < distance(mesh().vertices[b], closest.point); });
	s.thickness[v] = 0;
	enter(part, v, contact.force, s.pressureOf(contact.force, v), contact.seconds, touch);
}

HeatMapTouch HeatMap::add(int part, const HeatMapContact& contact) noexcept
{
	begin(part, contact);
	int budget = std::numeric_limits<int>::max();
	advance(budget);
	return m_touch;
}

void HeatMap::begin(int index, const HeatMapContact& contact) noexcept
{
	m_touch = {};
	const bool good = index >= 0 && index < parts() && isRigid(contact.X_OP) && contact.force >= 0 && std::isfinite(contact.force) &&
		isFinite(contact.point) && contact.seconds > 0 && std::isfinite(contact.seconds);
	Surface& s = *m_surface;
	s.part = nullptr;
	if (!good || mesh().triangles.empty() || m_parts[size_t(index)]->normals.empty()) return;
	if (++s.now == 0)
	{
		std::fill(s.stamp.begin(), s.stamp.end(), 0u);
		s.now = 1;
	}
	s.part = m_parts[size_t(index)].get();
	s.contact = contact;
	s.X_PO = inverse(contact.X_OP);
	s.near = {};
	s.area = s.sum = 0;
	s.cutUntil = 0;
	beginCollecting(*s.part);
}

bool HeatMap::advance(int& budget) noexcept
{
	Surface& s = *m_surface;
	if (!s.part) return true;
	s.budgetLeft = budget;
	const bool done = collect(*s.part) && cut();
	budget = s.budgetLeft;
	if (done) finish();
	return done;
}

/// Adds the contact to the map after all of it was evaluated.
void HeatMap::finish() noexcept
{
	Surface& s = *m_surface;
	Part& part = *s.part;
	const HeatMapContact& contact = s.contact;
	s.part = nullptr;
	m_touch.area = s.area;
	m_touch.depthSum = s.sum;
	if (s.sum > 0) enterArea(part, contact, contact.force / s.sum, m_touch);
	else enterPoint(part, contact, m_touch);
	part.seconds += contact.seconds;
	part.forceSum += contact.force * contact.seconds;
	part.peakForce = std::max(part.peakForce, contact.force);
	part.depth = std::max(part.depth, m_touch.depth);
	if (part.lastGrasp != m_grasps)
	{
		part.lastGrasp = m_grasps;
		++part.grasps;
	}
}

HeatMap::Vertex HeatMap::merged(uint32_t v, int only) const
{
	Vertex out;
	if (only >= parts()) return out;
	double longest = 0;
	for (int i = 0; i < parts(); ++i)
	{
		const Part& part = *m_parts[size_t(i)];
		if ((only >= 0 && i != only) || !(part.dwell[v] > 0)) continue;
		out.dwell += part.dwell[v];
		out.impulse += part.impulse[v];
		out.peak = std::max(out.peak, double(part.peak[v]));
		if (part.dwell[v] > longest) longest = part.dwell[v], out.part = i;
	}
	out.contact = double(only >= 0 ? m_parts[size_t(only)]->graspsAt.count[v] : m_surface->graspsAt.count[v]) / m_grasps;
	const double area = m_surface->vertexArea[v];
	if (out.dwell > 0 && area > 0) out.pressure = out.impulse / (area * out.dwell);
	return out;
}

std::vector<HeatMap::Vertex> HeatMap::vertices() const { return vertices(-1); }

std::vector<HeatMap::Vertex> HeatMap::vertices(int part) const
{
	std::vector<Vertex> all(mesh().vertices.size());
	for (uint32_t v = 0; v < all.size(); ++v) all[v] = merged(v, part);
	return all;
}

std::vector<HeatMap::Summary> HeatMap::summary() const
{
	std::vector<Summary> rows;
	for (const auto& part : m_parts)
	{
		Summary row{part->name, part->id, part->grasps, 0, part->seconds, part->seconds > 0 ? part->forceSum / part->seconds : 0,
			part->peakForce, part->forceSum, part->depth, 0};
		for (size_t v = 0; v < part->dwell.size(); ++v)
		{
			if (part->dwell[v] > 0) row.area += m_surface->vertexArea[v];
			row.peakPressure = std::max(row.peakPressure, double(part->peak[v]));
		}
		rows.push_back(row);
	}
	return rows;
}
}  // namespace devicebridge
