// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Distance/RayCrossings.h"

#include "BulletISTCollision/Core/Mesh/MeshEdges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ist
{
namespace
{
// Rays lean a little against the axes, because points on grids and faces of round bodies often share coordinates.
constexpr double kLeanU = 0.0137219, kLeanV = 0.0219743;
constexpr int kFewestAcross = 4, kMostAcross = 1024;
constexpr size_t kMostEntriesPerTriangle = 16;  // a finer grid than that costs more memory than the mesh
/// Widening of a triangle in its rows [sides of the grid]: far more than rounding, far less than a column.
constexpr double kSlack = 1e-9;
constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();  // of a 2 x 2 determinant, of the sum of its terms

bool isClosed(const Mesh& mesh)
{
	const std::vector<EdgeUse> edges = sortedEdges(mesh);
	bool balanced = true;
	forEachEdge(edges, [&](const EdgeUse* use, size_t count) {
		int64_t balance = 0;
		for (size_t i = 0; i < count; ++i) balance += use[i].forward ? 1 : -1;
		balanced = balanced && balance == 0;
	});
	return balanced && !edges.empty();
}

/// A determinant of two vectors, with the bound of its rounding error.
struct Determinant
{
	double value, error;
	Determinant(double au, double av, double bu, double bv)
		: value(au * bv - av * bu),
		  error(kRounding * (std::fabs(au * bv) + std::fabs(av * bu)))
	{}
	/// 0: it may have either sign.
	int sign() const { return value > error ? 1 : value < -error ? -1 : 0; }
};
}  // namespace

RayCrossings::RayCrossings(const Mesh& mesh, const Vec3& origin)
{
	const Box box = bounds(mesh);
	const Vec3 size = box.size();
	if (!isFinite(box.lower) || !isFinite(box.upper) || mesh.triangles.size() > UINT32_MAX / kMostEntriesPerTriangle) return;
	if (!(std::min({size.x, size.y, size.z}) > 0) || !isClosed(mesh)) return;
	// Rays along the shortest side meet the fewest triangles.
	for (int axis = 1; axis < 3; ++axis)
		if (size[axis] < size[m_axis]) m_axis = axis;
	// A vertex has the same coordinates in all its triangles, so the mesh stays closed.
	std::vector<Corner> corners;
	corners.reserve(mesh.vertices.size());
	for (const Vec3& p : mesh.vertices) corners.push_back(cornerOf(p - origin));
	m_triangles.reserve(mesh.triangles.size());
	double mostU = -std::numeric_limits<double>::infinity(), mostV = mostU;
	m_leastU = m_leastV = -mostU;
	for (const Triangle& t : mesh.triangles)
	{
		if (isCollapsed(t)) continue;
		m_triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
		for (const Corner& c : m_triangles.back())
		{
			m_leastU = std::min(m_leastU, c.u), mostU = std::max(mostU, c.u);
			m_leastV = std::min(m_leastV, c.v), mostV = std::max(mostV, c.v);
		}
	}
	m_slackU = kSlack * (mostU - m_leastU), m_slackV = kSlack * (mostV - m_leastV);
	const size_t most = std::max<size_t>(1024, kMostEntriesPerTriangle * m_triangles.size());
	for (m_across = std::clamp(int(std::sqrt(double(m_triangles.size()))), kFewestAcross, kMostAcross);; m_across /= 2)
	{
		m_perU = m_across / (mostU - m_leastU), m_perV = m_across / (mostV - m_leastV);
		if (!std::isfinite(m_perU) || !std::isfinite(m_perV)) m_across = 0;
		if (m_across == 0 || countSpans(most)) break;
	}
	if (isUsable()) list();
}

RayCrossings::Corner RayCrossings::cornerOf(const Vec3& p) const
{
	const double along = p[m_axis];
	return {p[(m_axis + 1) % 3] + kLeanU * along, p[(m_axis + 2) % 3] + kLeanV * along, along};
}

int RayCrossings::column(double u) const { return int(std::clamp((u - m_leastU) * m_perU, 0.0, double(m_across - 1))); }

int RayCrossings::row(double v) const { return int(std::clamp((v - m_leastV) * m_perV, 0.0, double(m_across - 1))); }

/// Visits the spans of a triangle, a little widened.
template <class Visit> void RayCrossings::forEachSpan(const Corners& t, const Visit& visit) const
{
	const auto [leastV, mostV] = std::minmax({t[0].v, t[1].v, t[2].v});
	const auto [leastU, mostU] = std::minmax({t[0].u, t[1].u, t[2].u});
	const int firstRow = row(leastV - m_slackV), lastRow = row(mostV + m_slackV);
	for (int r = firstRow; r <= lastRow; ++r)
	{
		double low = leastU, high = mostU;
		if (firstRow < lastRow && column(leastU) < column(mostU))
		{
			const double bottom = m_leastV + r / m_perV - m_slackV, top = m_leastV + (r + 1) / m_perV + m_slackV;
			low = mostU, high = leastU;
			const auto include = [&](double u) { low = std::min(low, u), high = std::max(high, u); };
			for (size_t k = 0; k < 3; ++k)
			{
				const Corner &a = t[k], &b = t[(k + 1) % 3];
				if (a.v >= bottom && a.v <= top) include(a.u);
				for (const double v : {bottom, top})
					if ((a.v < v) != (b.v < v)) include(a.u + (b.u - a.u) * std::clamp((v - a.v) / (b.v - a.v), 0.0, 1.0));
			}
			if (low > high) continue;
		}
		visit(Span{r, column(low - m_slackU), column(high + m_slackU)});
	}
}

/// Counts the entries of each cell. False if there are more than `most`.
bool RayCrossings::countSpans(size_t most)
{
	m_first.assign(size_t(m_across) * size_t(m_across) + 1, 0);
	size_t entries = 0;
	for (const Corners& t : m_triangles)
		forEachSpan(t, [&](const Span& s) {
			for (int k = s.first; k <= s.last; ++k) ++m_first[cellOf(s.row, k) + 1];
			entries += size_t(s.last - s.first + 1);
		});
	return entries <= most || m_across == 1;
}

void RayCrossings::list()
{
	std::partial_sum(m_first.begin(), m_first.end(), m_first.begin());
	m_entries.resize(m_first.back());
	std::vector<uint32_t> next(m_first.begin(), m_first.end() - 1);
	for (uint32_t i = 0; i < m_triangles.size(); ++i)
		forEachSpan(m_triangles[i], [&](const Span& s) {
			for (int k = s.first; k <= s.last; ++k) m_entries[next[cellOf(s.row, k)]++] = i;
		});
}

std::optional<int> RayCrossings::windingNumber(const Vec3& p) const
{
	const Corner at = cornerOf(p);
	const size_t cell = cellOf(row(at.v), column(at.u));
	int winding = 0;
	for (uint32_t e = m_first[cell]; e < m_first[cell + 1]; ++e)
	{
		const Corners& t = m_triangles[m_entries[e]];
		const auto [lowest, highest] = std::minmax({t[0].along, t[1].along, t[2].along});
		if (highest < at.along) continue;
		double u[3], v[3];
		for (size_t k = 0; k < 3; ++k) u[k] = t[k].u - at.u, v[k] = t[k].v - at.v;
		const Determinant w[3] = {{u[1], v[1], u[2], v[2]}, {u[2], v[2], u[0], v[0]}, {u[0], v[0], u[1], v[1]}};
		const int signs[3] = {w[0].sign(), w[1].sign(), w[2].sign()};
		if (std::min({signs[0], signs[1], signs[2]}) < 0 && std::max({signs[0], signs[1], signs[2]}) > 0) continue;
		if (signs[0] == 0 || signs[1] == 0 || signs[2] == 0) return {};
		if (lowest <= at.along)
		{
			double sum = 0, height = 0, error = 0;
			for (size_t k = 0; k < 3; ++k)
			{
				sum += w[k].value;
				height += w[k].value * (t[k].along - at.along);
				error += (w[k].error + kRounding * std::fabs(w[k].value)) * std::fabs(t[k].along - at.along);
			}
			if (!(std::fabs(height) > 2 * error)) return {};
			if ((height > 0) != (sum > 0)) continue;
		}
		winding += signs[0];
	}
	return winding;
}
}  // namespace ist
