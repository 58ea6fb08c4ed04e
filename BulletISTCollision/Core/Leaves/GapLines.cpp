// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Leaves/GapLines.h"

#include "BulletISTCollision/Core/Base/CounterRandom.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ist
{
GapLines::RowTable::RowTable(const std::vector<std::pair<double, double>>& extents, double lower, double spacing, int rows)
	: m_start(size_t(rows) + 1)
{
	const auto row = [&](double v) { return std::clamp(int(std::floor((v - lower) / spacing)), 0, rows - 1); };
	for (const auto& [lo, hi] : extents)
		for (int r = row(lo); r <= row(hi); ++r) ++m_start[size_t(r) + 1];
	std::partial_sum(m_start.begin(), m_start.end(), m_start.begin());
	m_items.resize(m_start.back());
	std::vector<size_t> next = m_start;
	for (uint32_t i = 0; i < extents.size(); ++i)
		for (int r = row(extents[i].first); r <= row(extents[i].second); ++r) m_items[next[size_t(r)]++] = i;
}

double GapLines::orientation(const Line& a, const Line& b, const Line& p) { return (b.u - a.u) * (p.v - a.v) - (b.v - a.v) * (p.u - a.u); }

/// Whether p lies left of the edge. It is evaluated from the lesser end, so that exactly one of the two triangles at an edge claims a
/// line.
bool GapLines::leftOf(const Line& a, const Line& b, const Line& p)
{
	const bool ordered = a.u < b.u || (a.u == b.u && a.v < b.v);
	return ordered ? orientation(a, b, p) >= 0 : !(orientation(b, a, p) >= 0);
}

GapLines::GapLines(
	const Mesh& mesh, const std::vector<Sphere>& spheres, int axis, const Box& box, double spacing, double step, uint64_t seed)
	: m_mesh(mesh),
	  m_spheres(spheres),
	  m_axis(axis),
	  m_u((axis + 1) % 3),
	  m_v((axis + 2) % 3),
	  m_spacing(spacing),
	  m_step(step),
	  m_seed(seed),
	  m_lower(box.lower),
	  m_columns(cellsAcross(box.size()[m_u])),
	  m_rows(cellsAcross(box.size()[m_v])),
	  m_triangleRows(triangleExtents(), m_lower[m_v], spacing, m_rows),
	  m_sphereRows(sphereExtents(), m_lower[m_v], spacing, m_rows)
{}

int GapLines::cellsAcross(double size) const { return std::max(1, int(std::ceil(size / m_spacing))); }

int GapLines::column(double u) const { return std::clamp(int(std::floor((u - m_lower[m_u]) / m_spacing)), 0, m_columns - 1); }

void GapLines::sampleRow(int row, std::vector<Vec3>& points) const
{
	CounterRandom random(m_seed, uint64_t(m_axis), uint64_t(row));
	std::vector<Line> lines(static_cast<size_t>(m_columns));
	for (int i = 0; i < m_columns; ++i)
	{
		lines[size_t(i)].u = m_lower[m_u] + (i + random.next()) * m_spacing;
		lines[size_t(i)].v = m_lower[m_v] + (row + random.next()) * m_spacing;
	}
	std::vector<Event> events;
	for (const uint32_t* t = m_triangleRows.begin(row); t != m_triangleRows.end(row); ++t) crossTriangle(*t, lines, events);
	for (const uint32_t* s = m_sphereRows.begin(row); s != m_sphereRows.end(row); ++s) crossSphere(m_spheres[*s], lines, events);
	std::sort(events.begin(), events.end(),
		[](const Event& a, const Event& b) { return a.column != b.column ? a.column < b.column : a.at < b.at; });
	placePoints(lines, events, random, points);
}

std::vector<std::pair<double, double>> GapLines::triangleExtents() const
{
	std::vector<std::pair<double, double>> extents;
	extents.reserve(m_mesh.triangles.size());
	for (const auto& t : m_mesh.triangles)
		extents.push_back(std::minmax({m_mesh.vertices[t[0]][m_v], m_mesh.vertices[t[1]][m_v], m_mesh.vertices[t[2]][m_v]}));
	return extents;
}

std::vector<std::pair<double, double>> GapLines::sphereExtents() const
{
	std::vector<std::pair<double, double>> extents;
	extents.reserve(m_spheres.size());
	for (const Sphere& s : m_spheres) extents.push_back({s.center()[m_v] - s.r, s.center()[m_v] + s.r});
	return extents;
}

void GapLines::crossTriangle(uint32_t index, const std::vector<Line>& lines, std::vector<Event>& events) const
{
	Line c[3];
	double at[3];
	for (int k = 0; k < 3; ++k)
	{
		const Vec3& p = m_mesh.vertices[m_mesh.triangles[index][size_t(k)]];
		c[k] = {p[m_u], p[m_v]};
		at[k] = p[m_axis];
	}
	const auto [left, right] = std::minmax({c[0].u, c[1].u, c[2].u});
	const auto [lowest, highest] = std::minmax({at[0], at[1], at[2]});
	const int last = column(right);
	for (int i = column(left); i <= last; ++i)
	{
		const Line& p = lines[size_t(i)];
		const bool side = leftOf(c[0], c[1], p);
		if (leftOf(c[1], c[2], p) != side || leftOf(c[2], c[0], p) != side) continue;
		const double w0 = orientation(c[1], c[2], p), w1 = orientation(c[2], c[0], p), w2 = orientation(c[0], c[1], p);
		const double sum = w0 + w1 + w2;
		const double t = sum != 0 ? (w0 * at[0] + w1 * at[1] + w2 * at[2]) / sum : 0.5 * (lowest + highest);
		events.push_back({i, std::clamp(t, lowest, highest), side ? -1 : 1, 0});
	}
}

void GapLines::crossSphere(const Sphere& s, const std::vector<Line>& lines, std::vector<Event>& events) const
{
	const Vec3 c = s.center();
	const double r = s.r;
	const int last = column(c[m_u] + r);
	for (int i = column(c[m_u] - r); i <= last; ++i)
	{
		const double du = lines[size_t(i)].u - c[m_u], dv = lines[size_t(i)].v - c[m_v];
		const double half2 = r * r - du * du - dv * dv;
		if (!(half2 > 0)) continue;
		const double half = std::sqrt(half2);
		events.push_back({i, c[m_axis] - half, 0, 1});
		events.push_back({i, c[m_axis] + half, 0, -1});
	}
}

/// Places one random point in every step along the gaps of the row's lines, laid end to end.
void GapLines::placePoints(
	const std::vector<Line>& lines, const std::vector<Event>& events, CounterRandom& random, std::vector<Vec3>& points) const
{
	double passed = 0, stratum = 0;
	double next = random.next() * m_step;
	int winding = 0, spheres = 0;
	for (size_t k = 0; k + 1 < events.size(); ++k)
	{
		const Event &e = events[k], &f = events[k + 1];
		winding += e.mesh;
		spheres += e.spheres;
		if (e.column != f.column)
		{
			winding = spheres = 0;
			continue;
		}
		if (winding < 1 || spheres > 0) continue;
		const double length = f.at - e.at;
		while (next < passed + length)
		{
			Vec3 p;
			p[m_axis] = e.at + (next - passed);
			p[m_u] = lines[size_t(e.column)].u;
			p[m_v] = lines[size_t(e.column)].v;
			points.push_back(p);
			stratum += 1;
			next = (stratum + random.next()) * m_step;
		}
		passed += length;
	}
}
}  // namespace ist
