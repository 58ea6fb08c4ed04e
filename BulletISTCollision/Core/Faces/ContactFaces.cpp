// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/ContactFaces.h"

#include "BulletISTCollision/Core/Faces/CellDepth.h"
#include "BulletISTCollision/Core/Faces/ElementPolygon.h"
#include "BulletISTCollision/Core/Query/Kernels/QueryKernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace ist
{
using namespace kernels;

namespace
{
/// A polygon is halved while the depth bends by more than this share of its largest value.
constexpr float kMostBend = 0.25f;
/// Rounding of depths per length of the domain; as far as this two surfaces are flush whatever their errors.
constexpr double kRounding = 1e-6;
/// Elements are cut at the planes if their radius is larger than this many median radii of the cells, or than this share of the body's
/// depth: four samples would miss a thin body.
constexpr float kLargestDepths = 0.5f;
constexpr float kLargestRadii = 4;
constexpr int kMostHalvings = 6, kStackSize = 96;
constexpr int kAllQuarters = -1;

typedef float Float4 __attribute__((vector_size(16)));

inline Float4 allLanes(float x) { return Float4{x, x, x, x}; }
inline Float4 load(const float* p)
{
	Float4 v;
	std::memcpy(&v, p, sizeof v);
	return v;
}

/// Turns what a kernel finds into faces, and cuts the elements that need it.
class FaceCollector
{
public:
	FaceCollector(const BodySurface& pressing, const BodySurface& pressed, const Pose& X_FS, FaceList& list)
		: m_elements(pressing.surface.elements.data()),
		  m_nodes(pressed.field.nodes.data()),
		  m_cells(pressed.field.cells.data()),
		  m_domain(pressed.field.domain),
		  m_X(X_FS),
		  m_rounding(float(depthRounding(pressed))),
		  m_list(list)
	{}

	void run(const BodySurface& pressing, const BodySurface& pressed, const QueryKernel& kernel);

private:
	struct Part
	{
		ElementPolygon polygon;
		uint32_t node;
	};

	void take(const FaceBatch& batch);
	void takeUncut(uint32_t element);
	void addWhole(const FaceBatch& batch, int k);
	void addCut(const FaceBatch& batch, int k);
	void addUncut(uint32_t index, int quarter);
	ElementPolygon wholePolygon() const;
	ElementPolygon quarterPolygon(int quarter) const;
	bool clipToDomain(ElementPolygon& polygon) const;
	void overlay(const ElementPolygon& polygon);
	bool isFar(const ElementPolygon& polygon, const DepthCell& cell) const;
	void addCell(const ElementPolygon& polygon, uint32_t cell);
	void addPolygon(const ElementPolygon& polygon, const ElementQuadratic& depth, int halvings);
	void addFace(const ElementPolygon& polygon, const ElementQuadratic& depth, float share);
	void addFlushFace(const ElementPolygon& polygon, float depth);
	static void halve(const ElementPolygon& polygon, ElementPolygon& below, ElementPolygon& above);
	static void keepInside(const ElementPolygon& polygon, const ElementQuadratic& depth, const float* value, ElementPolygon& inside);

	const SurfaceElement* m_elements;
	const DepthNode* m_nodes;
	const DepthCell* m_cells;
	const Box& m_domain;
	const Pose& m_X;
	const float m_rounding;
	FaceList& m_list;
	FaceSearch m_search{};

	// The element at hand, or a quarter of one, in the field's frame.
	uint32_t m_index = 0;
	bool m_isTriangle = false;
	Vec3 m_center, m_e1, m_e2, m_normal, m_normalS, m_normalT, m_unitNormal;
	double m_k11 = 0, m_k12 = 0, m_k22 = 0, m_error = 0;
	double m_areaScale = 0;  // area of the cluster per area of coordinates
	Float4 m_frame[3];       // x, y and z of (e1, e2, center)

	// The cell at hand.
	uint32_t m_cell = 0;
	float m_flush = 0;  // surfaces that are nearer than this lie in each other, as far as their errors tell [m]
	Vec3 m_gradient, m_gradientS, m_gradientT;
};

void FaceCollector::run(const BodySurface& pressing, const BodySurface& pressed, const QueryKernel& kernel)
{
	FaceSearch& search = m_search;
	static_cast<FieldTables&>(search) = fieldTablesOf(pressed);
	search.quads = pressing.tables.quads.data();
	search.elements = m_elements;
	for (int i = 0; i < 3; ++i)
	{
		search.domainLower[i] = float(m_domain.lower[i]);
		search.domainUpper[i] = float(m_domain.upper[i]);
		search.translation[i] = float(m_X.translation[i]);
		for (int j = 0; j < 3; ++j) search.rotation[3 * i + j] = float(m_X.rotation.m[i][j]);
	}
	search.margin = float(pressed.field.margin);
	search.rounding = m_rounding;
	search.largest = std::min(kLargestRadii * pressed.tables.cellRadius, kLargestDepths * m_nodes[0].deepest);
	search.take = [](void* self, const FaceBatch& batch) { static_cast<FaceCollector*>(self)->take(batch); };
	search.takeUncut = [](void* self, uint32_t element) { static_cast<FaceCollector*>(self)->takeUncut(element); };
	search.context = this;
	kernel.findFaces(search);
	m_list.counts.nodes += search.nodes;
	m_list.counts.elements += search.sampled;
	m_list.counts.quarters += search.quarters;
	m_list.dropped += size_t(search.dropped);
}

/// Spread and second moments of a face from the integrals of (x - center) (s - mean of s) dS and the same with t. e1, e2: derivatives of x
/// by s and t. normalS, normalT: those of the normal.
void setSpread(
	ContactFace& face, const Vec3& byS, const Vec3& byT, const Vec3& e1, const Vec3& e2, const Vec3& normalS, const Vec3& normalT)
{
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) face.spread.m[i][j] = byS[i] * normalS[j] + byT[i] * normalT[j];
	const auto second = [&](int i, int j) { return byS[i] * e1[j] + byT[i] * e2[j]; };
	face.second = {second(0, 0), second(1, 1), second(2, 2), second(0, 1), second(0, 2), second(1, 2)};
}

Vec3 vectorOf(const FaceBatch& batch, int column, int k)
{
	return {batch.column[column][k], batch.column[column + 1][k], batch.column[column + 2][k]};
}

void FaceCollector::take(const FaceBatch& batch)
{
	for (uint32_t b = batch.faces | batch.cut | batch.planes; b; b &= b - 1)
	{
		const int k = std::countr_zero(b);
		if (batch.faces >> k & 1) addWhole(batch, k);
		else if (batch.cut >> k & 1) addCut(batch, k);
		else addUncut(batch.element[k], batch.isOfQuarters ? int(batch.quarter[k]) : kAllQuarters);
	}
	m_search.stop = m_list.isOverLimit();
}

void FaceCollector::takeUncut(uint32_t element)
{
	addUncut(element, kAllQuarters);
	m_search.stop = m_list.isOverLimit();
}

/// Adds an element whose integrals the kernel has computed.
void FaceCollector::addWhole(const FaceBatch& batch, int k)
{
	if (!(batch.column[FaceBatch::DepthIntegral][k] > 0)) return;
	ContactFace* face = m_list.next();
	if (!face) return;
	face->center = vectorOf(batch, FaceBatch::FaceCenter, k);
	face->areaNormal = vectorOf(batch, FaceBatch::AreaNormal, k);
	face->pressure = vectorOf(batch, FaceBatch::Pressure, k);
	face->pressureCenter = vectorOf(batch, FaceBatch::PressureCenter, k);
	// The kernel gives the mean over the element, which may be many times larger than the face.
	face->gradient = vectorOf(batch, FaceBatch::Gradient, k) +
		gradientChange(m_cells[batch.cell[k]], face->center - m_X * toVec3(m_elements[batch.element[k]].center));
	setSpread(*face, vectorOf(batch, FaceBatch::SpreadS, k), vectorOf(batch, FaceBatch::SpreadT, k), vectorOf(batch, FaceBatch::E1, k),
		vectorOf(batch, FaceBatch::E2, k), vectorOf(batch, FaceBatch::NormalS, k), vectorOf(batch, FaceBatch::NormalT, k));
	face->area = batch.column[FaceBatch::Area][k];
	face->depth = batch.column[FaceBatch::DepthIntegral][k];
	face->cut = batch.column[FaceBatch::CutArea][k];
	face->element = batch.element[k];
	face->cell = batch.cell[k];
}

/// Adds an element that the zero level crosses in a way that the kernel does not treat.
void FaceCollector::addCut(const FaceBatch& batch, int k)
{
	const auto number = [&](int column) { return batch.column[column][k]; };
	m_index = batch.element[k];
	m_cell = batch.cell[k];
	m_center = vectorOf(batch, FaceBatch::Center, k);
	m_e1 = vectorOf(batch, FaceBatch::E1, k);
	m_e2 = vectorOf(batch, FaceBatch::E2, k);
	m_normal = vectorOf(batch, FaceBatch::Normal, k);
	m_unitNormal = vectorOf(batch, FaceBatch::Unit, k);
	m_normalS = vectorOf(batch, FaceBatch::NormalS, k);
	m_normalT = vectorOf(batch, FaceBatch::NormalT, k);
	m_k11 = number(FaceBatch::K11);
	m_k12 = number(FaceBatch::K12);
	m_k22 = number(FaceBatch::K22);
	m_isTriangle = number(FaceBatch::SignedArea) < 0;
	m_areaScale = m_isTriangle ? -2.0 * number(FaceBatch::SignedArea) : 0.25 * number(FaceBatch::SignedArea);
	m_flush = number(FaceBatch::Flush);
	m_gradient = vectorOf(batch, FaceBatch::Gradient, k);
	m_gradientS = gradientChange(m_cells[m_cell], m_e1);
	m_gradientT = gradientChange(m_cells[m_cell], m_e2);
	const auto depth = [&](int i) { return number(FaceBatch::Depth + i); };
	addPolygon(wholePolygon(), {depth(0), depth(1), depth(2), depth(3), depth(4), depth(5)}, 0);
}

/// Cuts an element, or a quarter of it, at the domain and at the planes of the partition.
void FaceCollector::addUncut(uint32_t index, int quarter)
{
	const SurfaceElement& e = m_elements[index];
	const Mat3& R = m_X.rotation;
	m_index = index;
	m_isTriangle = e.isTriangle != 0;
	m_center = m_X * toVec3(e.center);
	m_e1 = R * toVec3(e.e1);
	m_e2 = R * toVec3(e.e2);
	m_normal = R * toVec3(e.normal);
	m_unitNormal = normalized(m_normal);
	m_k11 = e.k11;
	m_k12 = e.k12;
	m_k22 = e.k22;
	m_error = e.error;
	m_normalS = m_normalT = {};
	if (m_k11 != 0 || m_k12 != 0 || m_k22 != 0)
	{
		const Vec3 product = cross(m_e1, m_e2), scaled = product / squaredNorm(product);
		const Vec3 dual1 = cross(m_e2, scaled), dual2 = cross(scaled, m_e1);
		m_normalS = m_k11 * dual1 + m_k12 * dual2;
		m_normalT = m_k12 * dual1 + m_k22 * dual2;
	}
	m_areaScale = e.isTriangle ? 2.0 * e.area : 0.25 * e.area;
	for (int axis = 0; axis < 3; ++axis) m_frame[axis] = Float4{float(m_e1[axis]), float(m_e2[axis]), float(m_center[axis]), 0};
	ElementPolygon polygon = quarter == kAllQuarters ? wholePolygon() : quarterPolygon(quarter);
	if (clipToDomain(polygon)) overlay(polygon);
}

ElementPolygon FaceCollector::wholePolygon() const
{
	ElementPolygon polygon;
	if (m_isTriangle)
	{
		polygon.add(0, 0);
		polygon.add(1, 0);
		polygon.add(0, 1);
	}
	else
	{
		polygon.add(-1, -1);
		polygon.add(1, -1);
		polygon.add(1, 1);
		polygon.add(-1, 1);
	}
	return polygon;
}

/// Quarters have the order of the kernels' takeQuarters.
ElementPolygon FaceCollector::quarterPolygon(int quarter) const
{
	const bool right = quarter & 1, upper = quarter & 2;
	const float least = m_isTriangle ? 0 : -1, half = 0.5f * (1 - least);
	ElementPolygon polygon;
	if (m_isTriangle && right && upper)
	{
		polygon.add(half, half);
		polygon.add(0, half);
		polygon.add(half, 0);
		return polygon;
	}
	const float s = right ? least + half : least, t = upper ? least + half : least;
	polygon.add(s, t);
	polygon.add(s + half, t);
	if (!m_isTriangle) polygon.add(s + half, t + half);
	polygon.add(s, t + half);
	return polygon;
}

/// Cuts off what lies outside of the field's domain. Returns false if nothing is left.
bool FaceCollector::clipToDomain(ElementPolygon& polygon) const
{
	for (int axis = 0; axis < 3; ++axis)
		for (const double sign : {1.0, -1.0})
		{
			const double limit = sign > 0 ? m_domain.upper[axis] : -m_domain.lower[axis];
			const ElementLine line{float(sign * m_e1[axis]), float(sign * m_e2[axis]), float(limit - sign * m_center[axis])};
			float value[ElementPolygon::kMost], largest = -1;
			for (int i = 0; i < polygon.count; ++i)
			{
				value[i] = line.at(polygon.s[i], polygon.t[i]);
				largest = std::max(largest, value[i]);
			}
			if (largest <= 0) continue;
			ElementPolygon inside, outside;
			polygon.split(value, inside, outside);
			if (inside.count < 3) return false;
			polygon = inside;
		}
	return true;
}

/// Cuts the polygon at the planes of the partition and adds each part with its cell.
void FaceCollector::overlay(const ElementPolygon& whole)
{
	Part stack[kStackSize];
	int top = 0;
	stack[top++] = {whole, 0};
	while (top > 0)
	{
		ElementPolygon polygon = stack[top - 1].polygon;
		uint32_t at = stack[--top].node;
		for (;;)
		{
			const DepthNode& node = m_nodes[at];
			if (node.deepest < 0) break;
			if (node.isCell())
			{
				addCell(polygon, node.cell());
				break;
			}
			++m_list.counts.planes;
			const Float4 line = m_frame[0] * allLanes(node.normal[0]) + m_frame[1] * allLanes(node.normal[1]) +
				m_frame[2] * allLanes(node.normal[2]);
			const Float4 a = allLanes(line[0]), b = allLanes(line[1]), c = allLanes(line[2] - node.offset);
			float value[ElementPolygon::kMost];
			float least = 1e30f, largest = -1e30f;
			for (int k = 0; k < polygon.count; k += 4)
			{
				const Float4 v = a * load(polygon.s + k) + b * load(polygon.t + k) + c;
				std::memcpy(value + k, &v, sizeof v);
			}
			for (int k = 0; k < polygon.count; ++k)
			{
				least = std::min(least, value[k]);
				largest = std::max(largest, value[k]);
			}
			if (largest <= 0 || least >= 0)
			{
				at = node.child + (least >= 0 && largest > 0);
				continue;
			}
			if (polygon.isFull() || top == kStackSize)
			{
				float sum = 0;
				for (int k = 0; k < polygon.count; ++k) sum += value[k];
				at = node.child + (sum > 0);
				continue;
			}
			++m_list.counts.cuts;
			ElementPolygon below;
			Part& above = stack[top];
			polygon.split(value, below, above.polygon);
			if (above.polygon.count >= 3)
			{
				above.node = node.child + 1;
				++top;
			}
			if (below.count < 3) break;
			polygon = below;
			at = node.child;
		}
	}
}

/// Whether the whole polygon is so far from the samples of its cell that none of the body is there.
bool FaceCollector::isFar(const ElementPolygon& polygon, const DepthCell& cell) const
{
	if (!(cell.error > kLeastErrorOfRadius * cell.radius)) return false;
	float s = 0, t = 0, reach = 0;
	for (int i = 0; i < polygon.count; ++i) s += polygon.s[i] / float(polygon.count), t += polygon.t[i] / float(polygon.count);
	for (int i = 0; i < polygon.count; ++i)
		reach = std::max(reach, float(norm(double(polygon.s[i] - s) * m_e1 + double(polygon.t[i] - t) * m_e2)));
	return distance(m_center + double(s) * m_e1 + double(t) * m_e2, toVec3(cell.center)) > double(kFarthestRadii * cell.radius + reach);
}

/// The depth over the element's plane, with the height of its sheet: what the height adds is the depth's slope along the normal times it.
void FaceCollector::addCell(const ElementPolygon& polygon, uint32_t index)
{
	++m_list.counts.cells;
	const DepthCell& cell = m_cells[index];
	if (isFar(polygon, cell)) return;
	const float x[3] = {m_frame[0][2], m_frame[1][2], m_frame[2][2]}, e1[3] = {m_frame[0][0], m_frame[1][0], m_frame[2][0]},
				e2[3] = {m_frame[0][1], m_frame[1][1], m_frame[2][1]};
	const float normal[3] = {float(m_unitNormal.x), float(m_unitNormal.y), float(m_unitNormal.z)};
	const CellDepth at = depthIn(cell, x);
	float h1[3], h2[3];
	timesHessian(cell, e1, h1);
	timesHessian(cell, e2, h2);
	const float slope = dot3(at.gradient, normal);
	m_cell = index;
	// Only surfaces that look the same way can lie in each other; those of bodies that touch look at each other.
	m_flush = kFlushErrors * std::clamp(-2 * slope, 0.0f, 1.0f) * (cell.error + float(m_error)) + m_rounding;
	m_gradient = toVec3(at.gradient);
	m_gradientS = toVec3(h1);
	m_gradientT = toVec3(h2);
	const ElementQuadratic depth{at.depth + slope * float((m_k11 + m_k22) / 6), dot3(at.gradient, e1), dot3(at.gradient, e2),
		dot3(e1, h1) - slope * float(m_k11), dot3(e1, h2) - slope * float(m_k12), dot3(e2, h2) - slope * float(m_k22)};
	addPolygon(polygon, depth, 0);
}

void FaceCollector::addPolygon(const ElementPolygon& polygon, const ElementQuadratic& depth, int halvings)
{
	float value[ElementPolygon::kMost], least = 1e30f, largest = -1e30f, sum = 0, s = 0, t = 0;
	for (int i = 0; i < polygon.count; ++i)
	{
		value[i] = depth.at(polygon.s[i], polygon.t[i]);
		least = std::min(least, value[i]);
		largest = std::max(largest, value[i]);
		sum += value[i];
		s += polygon.s[i];
		t += polygon.t[i];
	}
	const float share = 1 / float(polygon.count), middle = depth.at(s * share, t * share), bend = middle - sum * share;
	const float top = std::max(largest, middle) + std::max(0.0f, bend);
	if (top <= -m_flush) return;
	if (top < m_flush && least > -m_flush) return addFlushFace(polygon, middle);
	if (top <= 0) return;
	if (least >= 0 && middle >= 0) return addFace(polygon, depth, 1);
	if (std::fabs(bend) > kMostBend * top && halvings < kMostHalvings && !polygon.isFull())
	{
		++m_list.counts.halvings;
		ElementPolygon below, above;
		halve(polygon, below, above);
		if (below.count >= 3) addPolygon(below, depth, halvings + 1);
		if (above.count >= 3) addPolygon(above, depth, halvings + 1);
		return;
	}
	ElementPolygon inside;
	keepInside(polygon, depth, value, inside);
	if (inside.count < 3) return;
	const float whole = polygon.moments().area;
	addFace(inside, depth, whole > 0 ? std::min(1.0f, inside.moments().area / whole) : 1);
}

/// Splits the polygon across its longer side.
void FaceCollector::halve(const ElementPolygon& polygon, ElementPolygon& below, ElementPolygon& above)
{
	float lowS = polygon.s[0], highS = lowS, lowT = polygon.t[0], highT = lowT, value[ElementPolygon::kMost];
	for (int i = 1; i < polygon.count; ++i)
	{
		lowS = std::min(lowS, polygon.s[i]);
		highS = std::max(highS, polygon.s[i]);
		lowT = std::min(lowT, polygon.t[i]);
		highT = std::max(highT, polygon.t[i]);
	}
	const bool acrossS = highS - lowS > highT - lowT;
	for (int i = 0; i < polygon.count; ++i)
		value[i] = acrossS ? polygon.s[i] - 0.5f * (lowS + highS) : polygon.t[i] - 0.5f * (lowT + highT);
	polygon.split(value, below, above);
}

/// Keeps the part of the polygon where the depth is positive. Its curved border becomes two chords that meet on it.
void FaceCollector::keepInside(const ElementPolygon& polygon, const ElementQuadratic& depth, const float* value, ElementPolygon& inside)
{
	inside.count = 0;
	int crossings = 0, last = -1;
	float crossS[2], crossT[2];
	for (int i = 0, next = 1; i < polygon.count; ++i, ++next)
	{
		if (next == polygon.count) next = 0;
		if (value[i] >= 0) inside.add(polygon.s[i], polygon.t[i]);
		if ((value[i] < 0) == (value[next] < 0)) continue;
		const float ds = polygon.s[next] - polygon.s[i], dt = polygon.t[next] - polygon.t[i];
		float share = value[i] / (value[i] - value[next]);
		// One step of Newton's method along the edge.
		const float s = polygon.s[i] + share * ds, t = polygon.t[i] + share * dt, slope = depth.slopeS(s, t) * ds + depth.slopeT(s, t) * dt;
		if (slope * (value[next] - value[i]) > 0) share = std::clamp(share - depth.at(s, t) / slope, 0.0f, 1.0f);
		const float x = polygon.s[i] + share * ds, y = polygon.t[i] + share * dt;
		if (crossings < 2)
		{
			crossS[crossings] = x;
			crossT[crossings] = y;
		}
		if (value[i] >= 0) last = inside.count;
		++crossings;
		inside.add(x, y);
	}
	if (crossings != 2 || inside.isFull()) return;
	const float s = 0.5f * (crossS[0] + crossS[1]), t = 0.5f * (crossT[0] + crossT[1]);
	const float slopeS = depth.slopeS(s, t), slopeT = depth.slopeT(s, t), squared = slopeS * slopeS + slopeT * slopeT;
	if (!(squared > 0)) return;
	const float step = depth.at(s, t) / squared, limit = 0.5f * (std::fabs(crossS[1] - crossS[0]) + std::fabs(crossT[1] - crossT[0]));
	if (std::fabs(step) * std::sqrt(squared) > limit) return;
	// The chords must leave an area: where they would cross the opposite edge, that of a sliver is negative.
	const int entry = last + 1 < inside.count ? last + 1 : 0;
	const float s0 = inside.s[last], t0 = inside.t[last], x = s - step * slopeS, y = t - step * slopeT;
	const float added = 0.5f * ((x - s0) * (inside.t[entry] - t0) - (y - t0) * (inside.s[entry] - s0));
	if (added < -0.5f * inside.moments().area) return;
	inside.insert(last + 1, x, y);
}

/// Adds a polygon that lies in the other surface, as far as their errors can tell. Half of it counts as inside.
void FaceCollector::addFlushFace(const ElementPolygon& polygon, float depth)
{
	const PolygonMoments m = polygon.moments();
	const double s = double(m.s) / m.area, t = double(m.t) / m.area, above = std::clamp(double(depth) + m_flush, 0.0, 2.0 * m_flush);
	const double inside = m_areaScale * m.area * above / (2 * m_flush), pressed = m_areaScale * m.area * above * above / (4 * m_flush);
	// Where the depth bends, the middle may lie below all corners, and outside of the other body.
	if (!(pressed > 0)) return;
	ContactFace* face = m_list.next();
	if (!face) return;
	const Vec3 normal = m_normal + s * m_normalS + t * m_normalT;
	face->center = face->pressureCenter = m_center + s * m_e1 + t * m_e2;
	face->areaNormal = inside * normal;
	face->pressure = pressed * normal;
	face->gradient = m_gradient + s * m_gradientS + t * m_gradientT;
	face->spread = zeroMat3();
	face->area = inside;
	face->depth = pressed;
	face->cut = kFlushCut * inside;
	face->element = m_index;
	face->cell = m_cell;
}

/// Way from the centroid to where the depth presses, along one coordinate. A depth that is negative on a part of the polygon could have it
/// outside: it stays within the element, whose coordinates go from -1 to 1.
double limitedShift(double moment, double integral, double centroid)
{
	return std::clamp(moment / integral, std::min(-1 - centroid, 0.0), std::max(1 - centroid, 0.0));
}

/// Adds a polygon on which the depth counts as positive. `share`: of the polygon that was cut where the depth is zero.
void FaceCollector::addFace(const ElementPolygon& polygon, const ElementQuadratic& d, float share)
{
	const PolygonMoments m = polygon.moments();
	if (!(m.area > 0)) return;
	const double integral = double(d.c) * m.area + double(d.cs) * m.s + double(d.ct) * m.t +
		0.5 * (double(d.css) * m.ss + 2 * double(d.cst) * m.st + double(d.ctt) * m.tt);
	if (!(integral > 0)) return;
	ContactFace* face = m_list.next();
	if (!face) return;
	const double w = m_areaScale, s = double(m.s) / m.area, t = double(m.t) / m.area;
	float top = d.at(float(s), float(t));
	for (int i = 0; i < polygon.count; ++i) top = std::max(top, d.at(polygon.s[i], polygon.t[i]));
	const double area = w * m.area * std::min(1.0, integral / (double(kLeastMean) * m.area * std::max(top, 1e-30f)));
	// First moments of the depth, from its tangent plane at the centroid.
	const double slopeS = d.cs + double(d.css) * s + double(d.cst) * t, slopeT = d.ct + double(d.cst) * s + double(d.ctt) * t;
	const double varS = m.ss - double(m.s) * s, varST = m.st - double(m.s) * t, varT = m.tt - double(m.t) * t;
	const double shiftS = limitedShift(slopeS * varS + slopeT * varST, integral, s),
				 shiftT = limitedShift(slopeS * varST + slopeT * varT, integral, t);
	const double ds = integral * (s + shiftS), dt = integral * (t + shiftT);
	const Vec3 onPlane = m_center + s * m_e1 + t * m_e2;
	const double height = (m_k11 + m_k22) / 6 - 0.5 * (m_k11 * m.ss + 2 * m_k12 * m.st + m_k22 * m.tt) / m.area;
	face->center = onPlane + height * m_unitNormal;
	face->areaNormal = area * (m_normal + s * m_normalS + t * m_normalT);
	face->pressure = w * (integral * m_normal + ds * m_normalS + dt * m_normalT);
	face->pressureCenter = m_center + (s + shiftS) * m_e1 + (t + shiftT) * m_e2 + height * m_unitNormal;
	face->gradient = m_gradient + s * m_gradientS + t * m_gradientT;
	const double spread = area / m.area;
	setSpread(*face, spread * (varS * m_e1 + varST * m_e2), spread * (varST * m_e1 + varT * m_e2), m_e1, m_e2, m_normalS, m_normalT);
	face->area = area;
	face->depth = w * integral;
	face->cut = area * (1 - share);
	face->element = m_index;
	face->cell = m_cell;
}
}  // namespace

kernels::FieldTables fieldTablesOf(const BodySurface& body)
{
	const QueryTables& tables = body.tables;
	FieldTables field{tables.planes.data(), tables.starts.data(), body.field.cells.data(), {}, {}, {}};
	for (int i = 0; i < 3; ++i)
	{
		field.lower[i] = tables.lower[i];
		field.voxelsPerLength[i] = tables.voxelsPerLength[i];
		field.size[i] = tables.size[i];
	}
	return field;
}

double depthRounding(const BodySurface& body) { return kRounding * body.field.domain.longestSide(); }

void collectFaces(const BodySurface& pressing, const BodySurface& pressed, const Pose& X_FS, const QueryKernel& kernel, FaceList& list)
{
	if (pressing.tables.empty() || pressed.tables.empty()) return;
	FaceCollector(pressing, pressed, X_FS, list).run(pressing, pressed, kernel);
}
}  // namespace ist
