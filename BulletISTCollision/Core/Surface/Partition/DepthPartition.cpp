// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/Partition/DepthPartition.h"

#include "BulletISTCollision/Core/Surface/Partition/SplitPlane.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

namespace ist
{
namespace
{
constexpr size_t kFewestToSplit = 2;
constexpr size_t kEnoughToFit = 2000;  // of the samples of a node
// The field is exact where no sample is off by more than this share of the longest side: about the rounding of a float.
constexpr double kExact = 1e-7;
// Samples this near to a plane belong to neither side: the rounding of the plane could give one of them to the wrong face.
constexpr double kPlaneRounding = 2e-7;
constexpr double kMisfit = 4;  // a sample with this many times the error of its cell is a misfit
// Points of small pieces weigh as if the surface had this many samples in a square of the spacing.
constexpr double kSamplesOfSquare = 16;
constexpr double kShrinking = 0.9;  // of the corners of a piece of surface towards its middle
// The depth between samples may exceed that at the samples by this factor times their typical distance. One or two samples show no
// distance, so a share of the spacing is added.
constexpr double kDeepestSlack = 2;
constexpr double kOutsideShare = 0.5;
// Nodes are split in parallel. A child seldom comes before a node with this share of its parent's priority.
constexpr double kBatchSpan = 0.5;
constexpr size_t kLargestBatch = 4096;
constexpr double kLeastSlope = 0.3;  // of a quadric whose gradient says where outside is
constexpr double kSlack = 0.05;      // of the spacing; the corners of an element stand this far above a curved surface
constexpr double kNever = -1;        // priority of a node that is not split
constexpr uint64_t kPlaneStream = 12, kOutsideStream = 64;
constexpr int kOutsidePoints = 48;  // in each cell, to look for a positive depth outside of the body

DepthCell cellOf(const QuadricFit& fit)
{
	DepthCell cell;
	for (int k = 0; k < 3; ++k)
	{
		cell.center[k] = float(fit.quadric.center[k]);
		cell.gradient[k] = float(fit.quadric.gradient[k]);
	}
	for (int k = 0; k < 6; ++k) cell.hessian[k] = float(fit.quadric.hessian[k]);
	cell.depth = float(fit.quadric.depth);
	cell.error = float(fit.error);
	cell.radius = float(fit.radius);
	return cell;
}

Vec3 middleOf(std::span<const Vec3> polygon)
{
	Vec3 sum;
	for (const Vec3& p : polygon) sum += p;
	return sum / double(polygon.size());
}

/// A point between four of the corners of a convex region.
Vec3 randomPoint(const std::vector<Vec3>& corners, CounterRandom& random)
{
	Vec3 sum;
	double weights = 0;
	for (int k = 0; k < 4; ++k)
	{
		const size_t corner = std::min(corners.size() - 1, size_t(random.next() * double(corners.size())));
		const double weight = -std::log1p(-random.next());
		sum += weight * corners[corner];
		weights += weight;
	}
	return weights > 0 ? sum / weights : corners.front();
}

double areaOf(std::span<const Vec3> polygon)
{
	Vec3 sum;
	for (size_t i = 2; i < polygon.size(); ++i) sum += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
	return norm(sum) / 2;
}
}  // namespace

DepthPartition::DepthPartition(const Mesh& mesh, std::vector<DepthSample> samples, const DepthPartitionOptions& options)
	: m_mesh(mesh),
	  m_tolerance(surfaceTolerance(mesh)),
	  m_options(options)
{
	m_nodes.resize(1);
	m_nodes[0].child = DepthNode::kCell;
	m_parts.push_back(partOf(std::move(samples), ClippedSurface(mesh)));
	m_queue.push({m_parts[0].priority, 0});
}

bool DepthPartition::split(size_t most, const std::function<bool(double)>& goesOn)
{
	std::vector<size_t> batch;
	std::vector<Halves> halves;
	while (takeBatch(most, batch))
	{
		if (!goesOn(double(m_parts.size()) / double(m_options.cells))) return false;
		halves.assign(batch.size(), {});
#pragma omp parallel for schedule(dynamic, 1) num_threads(m_options.threads) if (batch.size() > 1)
		for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(batch.size()); ++i) halves[size_t(i)] = halvesOf(m_parts[batch[size_t(i)]]);
		for (size_t i = 0; i < batch.size(); ++i)
			if (halves[i].isSplit) add(batch[i], halves[i]);
	}
	return true;
}

/// Takes the parts with about the largest priority, as many as there is room for.
bool DepthPartition::takeBatch(size_t most, std::vector<size_t>& batch)
{
	batch.clear();
	const size_t room = m_parts.size() >= most ? 0 : std::min(kLargestBatch, most - m_parts.size());
	double least = -1;
	for (; !m_queue.empty() && batch.size() < room && m_queue.top().first >= least; m_queue.pop())
	{
		const auto [priority, part] = m_queue.top();
		if (priority <= 0) break;
		// A part that was fitted again stands in the queue twice.
		if (priority != m_parts[part].priority) continue;
		if (batch.empty()) least = kBatchSpan * priority;
		batch.push_back(part);
	}
	std::sort(batch.begin(), batch.end());
	batch.erase(std::unique(batch.begin(), batch.end()), batch.end());
	return !batch.empty();
}

/// Fits the cell of a part to its samples, and sets its priority.
void DepthPartition::fit(Part& part) const
{
	part.priority = kNever;
	const std::vector<DepthSample>& all = part.samples;
	const size_t stride = std::max<size_t>(1, all.size() / kEnoughToFit);
	if (stride == 1) part.fit = fitQuadric(all, m_options.spacing);
	else
	{
		std::vector<DepthSample> some;
		for (size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
		part.fit = fitQuadric(some, m_options.spacing);
		for (const DepthSample& s : all) part.fit.largest = std::max(part.fit.largest, std::fabs(errorAt(part.fit, s, m_options.spacing)));
	}
	// A node without samples in the body is not split: all that counts there is that its depth is negative.
	if (all.size() >= kFewestToSplit && part.fit.within > 0 && part.fit.largest > kExact * m_options.size)
		part.priority = std::max(std::numeric_limits<double>::min(), part.fit.squares * double(stride));
}

DepthPartition::Part DepthPartition::partOf(std::vector<DepthSample> samples, ClippedSurface surface) const
{
	Part part;
	part.samples = std::move(samples);
	part.surface = std::move(surface);
	fit(part);
	return part;
}

/// Reorders the samples of the parent.
DepthPartition::Halves DepthPartition::halvesOf(Part& parent) const
{
	Halves halves;
	const CounterRandom random(m_options.seed, kPlaneStream, parent.node);
	const double rounding = kPlaneRounding * m_options.size;
	const auto plane = findSplitPlane(parent.samples, parent.fit, m_options.spacing, rounding, random);
	if (!plane) return halves;
	for (int k = 0; k < 3; ++k) halves.node.normal[k] = float(plane->normal[k]);
	halves.node.offset = float(plane->offset);
	const auto begin = parent.samples.begin(), end = parent.samples.end();
	const auto first = std::partition(begin, end, [&](const DepthSample& s) { return halves.node.beyond(s.position) <= -rounding; });
	const auto second = std::partition(first, end, [&](const DepthSample& s) { return halves.node.beyond(s.position) < rounding; });
	if (first == begin || second == end) return halves;
	auto [below, above] = parent.surface.halves(m_mesh, halves.node, m_tolerance);
	halves.first = partOf({begin, first}, std::move(below));
	halves.second = partOf({second, end}, std::move(above));
	halves.isSplit = true;
	return halves;
}

void DepthPartition::add(size_t parent, Halves& halves)
{
	const size_t child = m_nodes.size();
	halves.first.node = child;
	halves.second.node = child + 1;
	halves.node.child = uint32_t(child);
	m_nodes[m_parts[parent].node] = halves.node;
	m_nodes.resize(child + 2);
	m_nodes[child].child = uint32_t(parent) | DepthNode::kCell;
	m_nodes[child + 1].child = uint32_t(m_parts.size()) | DepthNode::kCell;
	m_parts[parent] = std::move(halves.first);
	m_parts.push_back(std::move(halves.second));
	m_queue.push({m_parts[parent].priority, parent});
	m_queue.push({m_parts.back().priority, m_parts.size() - 1});
}

size_t DepthPartition::partAt(const Vec3& x) const
{
	const DepthNode* node = m_nodes.data();
	while (!node->isCell()) node = &m_nodes[node->child + (node->beyond(x) > 0 ? 1 : 0)];
	return node->cell();
}

bool DepthPartition::isMisfit(size_t part, const DepthSample& sample) const
{
	const QuadricFit& fit = m_parts[part].fit;
	// A cell without samples in the body was fitted to depths outside.
	if (fit.within == 0) return !sample.isOutside();
	// While there is room for more cells, the field can become exact.
	const double most = isFull() ? std::max(kExact * m_options.size, kMisfit * fit.error) : kExact * m_options.size;
	return std::fabs(errorAt(fit, sample, m_options.spacing)) > most;
}

/// Gives each part its misfits and fits its cell again. Returns the number of misfits.
size_t DepthPartition::addToParts(const std::function<std::vector<DepthSample>(size_t part)>& misfitsOf)
{
	std::vector<size_t> added(m_parts.size());
#pragma omp parallel for schedule(dynamic, 16) num_threads(m_options.threads)
	for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(m_parts.size()); ++i)
	{
		const std::vector<DepthSample> misfits = misfitsOf(size_t(i));
		if (misfits.empty()) continue;
		Part& part = m_parts[size_t(i)];
		part.samples.insert(part.samples.end(), misfits.begin(), misfits.end());
		fit(part);
		added[size_t(i)] = misfits.size();
	}
	for (size_t i = 0; i < added.size(); ++i)
		if (added[i] > 0) m_queue.push({m_parts[i].priority, i});
	return std::accumulate(added.begin(), added.end(), size_t(0));
}

size_t DepthPartition::addMisfits(const std::vector<DepthSample>& samples)
{
	constexpr uint32_t kNone = UINT32_MAX;
	std::vector<uint32_t> partOfMisfit(samples.size(), kNone);
#pragma omp parallel for schedule(dynamic, 1024) num_threads(m_options.threads)
	for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(samples.size()); ++i)
	{
		const DepthSample& s = samples[size_t(i)];
		const size_t part = partAt(s.position);
		if (isMisfit(part, s)) partOfMisfit[size_t(i)] = uint32_t(part);
	}
	std::vector<size_t> first(m_parts.size() + 1);
	for (const uint32_t part : partOfMisfit)
		if (part != kNone) ++first[part + 1];
	std::partial_sum(first.begin(), first.end(), first.begin());
	std::vector<size_t> misfits(first.back()), next(first.begin(), first.end() - 1);
	for (size_t i = 0; i < samples.size(); ++i)
		if (partOfMisfit[i] != kNone) misfits[next[partOfMisfit[i]]++] = i;
	return addToParts([&](size_t part) {
		std::vector<DepthSample> own;
		own.reserve(first[part + 1] - first[part]);
		for (size_t k = first[part]; k < first[part + 1]; ++k) own.push_back(samples[misfits[k]]);
		return own;
	});
}

/// Those corners of the surface in a part that its cell does not match.
std::vector<DepthSample> DepthPartition::misfitsOfSurface(size_t part) const
{
	std::vector<DepthSample> misfits;
	const double weight = weightOfDepth(0, m_options.spacing), area = m_options.spacing * m_options.spacing / kSamplesOfSquare;
	m_parts[part].surface.forEach(m_mesh, [&](size_t triangle, std::span<const Vec3> polygon) {
		const auto& t = m_mesh.triangles[triangle];
		const Vec3& a = m_mesh.vertices[t[0]];
		const Vec3 normal = normalized(cross(m_mesh.vertices[t[1]] - a, m_mesh.vertices[t[2]] - a));
		const Vec3 middle = middleOf(polygon);
		const double share = std::min(1.0, areaOf(polygon) / (area * double(polygon.size())));
		for (const Vec3& corner : polygon)
		{
			const DepthSample s{middle + (corner - middle) * kShrinking, 0, normal, weight * share};
			if (share > 0 && isMisfit(part, s) && partAt(s.position) == part) misfits.push_back(s);
		}
	});
	return misfits;
}

size_t DepthPartition::addMisfitsOfSurface()
{
	return addToParts([this](size_t part) { return misfitsOfSurface(part); });
}

/// Finds the corners of the region of each cell below a node, by its part.
void DepthPartition::cornersOf(size_t node, ConvexRegion region, std::vector<std::vector<Vec3>>& corners) const
{
	if (m_nodes[node].isCell())
	{
		corners[m_nodes[node].cell()] = region.corners();
		return;
	}
	ConvexRegion first = region;
	first.clip(m_nodes[node], 0);
	cornersOf(m_nodes[node].child, std::move(first), corners);
	region.clip(m_nodes[node], 1);
	cornersOf(m_nodes[node].child + 1, std::move(region), corners);
}

size_t DepthPartition::addMisfitsOutside(const MeshDistance& surface, const Box& domain, uint64_t stream)
{
	std::vector<std::vector<Vec3>> corners(m_parts.size());
	cornersOf(0, ConvexRegion(domain), corners);
	return addToParts([&](size_t part) {
		std::vector<DepthSample> misfits;
		if (corners[part].empty() || m_parts[part].fit.within == 0) return misfits;
		CounterRandom random(m_options.seed, kOutsideStream + stream, part);
		for (int k = 0; k < kOutsidePoints; ++k)
		{
			const Vec3 x = randomPoint(corners[part], random);
			if (!(m_parts[part].fit.quadric.depthAt(x) > 0) || surface.contains(x)) continue;
			const MeshDistance::Field f = surface.field(x, false);
			const DepthSample s{x, f.depth, f.normal, weightOfDepth(f.depth, m_options.spacing)};
			if (isMisfit(part, s) && partAt(x) == part) misfits.push_back(s);
		}
		return misfits;
	});
}

/// Upper bound of the depth in a part, from its samples.
double DepthPartition::deepestOf(const Part& part, bool holdsSurface) const
{
	double deepest = -std::numeric_limits<double>::infinity();
	for (const DepthSample& s : part.samples) deepest = std::max(deepest, s.depth);
	if (!holdsSurface && deepest < 0) return kOutsideShare * deepest;
	const double count = double(std::max<size_t>(1, part.fit.within));
	return std::max(deepest, 0.0) + kDeepestSlack * part.fit.radius / std::cbrt(count) + m_options.spacing / count;
}

/// The height of the highest point of the body in a part that is known [m].
double DepthPartition::heightOf(const Part& part, const Vec3& up) const
{
	double highest = -std::numeric_limits<double>::infinity();
	part.surface.forEach(m_mesh, [&](size_t, std::span<const Vec3> polygon) {
		for (const Vec3& p : polygon) highest = std::max(highest, dot(up, p));
	});
	for (const DepthSample& s : part.samples)
		if (!s.isOutside()) highest = std::max(highest, dot(up, s.position));
	return highest;
}

/// Splits each node that holds surface once more: what lies above all of the body in it is outside. Without this, the quadric of a cell
/// could be positive far away, where there are few samples.
void DepthPartition::cutOffOutside(std::vector<DepthNode>& nodes) const
{
	for (const Part& p : m_parts)
	{
		if (p.surface.empty() || p.fit.within == 0 || norm(p.fit.quadric.gradient) < kLeastSlope) continue;
		const Vec3 up = normalized(-p.fit.quadric.gradient);
		const size_t child = nodes.size();
		nodes.resize(child + 2);
		DepthNode& node = nodes[p.node];
		nodes[child].child = node.child;
		nodes[child + 1].child = DepthNode::kOutside;
		nodes[child + 1].deepest = -1;
		for (int k = 0; k < 3; ++k) node.normal[k] = float(up[k]);
		node.offset = std::nextafter(float(heightOf(p, up) + kSlack * m_options.spacing), std::numeric_limits<float>::infinity());
		node.child = uint32_t(child);
	}
}

DepthField DepthPartition::field(const Box& domain) const
{
	std::vector<DepthNode> nodes = m_nodes;
	std::vector<DepthCell> cells;
	for (const Part& part : m_parts)
	{
		nodes[part.node].deepest = float(deepestOf(part, !part.surface.empty()));
		cells.push_back(cellOf(part.fit));
	}
	cutOffOutside(nodes);
	for (size_t i = m_nodes.size(); i < nodes.size(); ++i)
		if (!nodes[i].isOutside()) nodes[i].deepest = nodes[m_parts[nodes[i].cell()].node].deepest;
	for (size_t i = nodes.size(); i-- > 0;)
		if (!nodes[i].isCell()) nodes[i].deepest = std::max(nodes[nodes[i].child].deepest, nodes[nodes[i].child + 1].deepest);
	return {std::move(nodes), std::move(cells), domain, bounds(m_mesh).lower.x - domain.lower.x};
}
}  // namespace ist
