// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/ClusterSplit.h"
#include "BulletISTCollision/Core/Surface/ContactSurface.h"
#include "BulletISTCollision/Core/Surface/ElementShape.h"
#include "BulletISTCollision/Core/Surface/FlatFace.h"
#include "BulletISTCollision/Core/Surface/FlatRegions.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace ist
{
namespace
{
constexpr int64_t kFewestElements = 24, kMostElements = int64_t(1) << 28;
constexpr int kSplitsPerReport = 256;

// Weights of a cluster's priority: that of its size alone, of its normal spread, and of sheets that lie apart. A wide spread (0.25 is a
// cap of 120 degrees) counts twice.
constexpr double kSizeWeight = 0.02, kSpreadWeight = 8, kWideSpreadWeight = 16, kThicknessWeight = 30;
constexpr double kSparse = 0.5;  // area that a cluster counts for at least [square of its radius]; the share is 2 for a square
// A crease or the two sides of a thin part: most of the variance of the normals goes with the split.
constexpr double kCrease = 0.12;
constexpr double kWideCrease = 0.3, kWideSpread = 0.15;  // looser where the normal spread is wide
// Few triangles of the size of elements, as those of a box, are sorted by their normals first, so that flat faces come out whole.
constexpr double kFewLeft = 0.9;
constexpr size_t kFew = 64;
constexpr double kSliver = 7;        // (longest edge)^2 / area; 4 for half a square, 6.7 for half a rectangle of 3 : 1
constexpr double kLong = 2.5;        // length of a flat sliver that is cut [size of an element]
constexpr double kLongVariance = 9;  // ratio of the variances of a rectangle of 3 : 1
constexpr double kOutline = 0.02;    // tolerance of the outline of a flat face [size of an element, or of the face if that is smaller]
// Elements around holes: those that stand out by more than this share of an element are split, up to so many times the wanted elements.
constexpr double kRim = 1e-4, kMostWithRims = 1.5;
constexpr double kDegenerate = 1e-12;  // area of a triangle that is left out [square of its longest edge]

/// The triangles of a mesh that have an area. `triangles` receives their indices.
std::vector<SurfacePiece> piecesOf(const Mesh& mesh, std::vector<uint32_t>& triangles)
{
	std::vector<SurfacePiece> pieces;
	pieces.reserve(mesh.triangles.size() * 5 / 4);
	for (size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const auto& t = mesh.triangles[i];
		SurfacePiece p{{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, {}, 0};
		const Vec3 a = p.corners[1] - p.corners[0], b = p.corners[2] - p.corners[0], product = cross(a, b);
		const double longest = std::max({squaredNorm(a), squaredNorm(b), squaredNorm(b - a)});
		p.area = 0.5 * norm(product);
		p.normal = normalized(product);
		if (!(p.area > kDegenerate * longest)) continue;
		pieces.push_back(p);
		triangles.push_back(uint32_t(i));
	}
	return pieces;
}

/// A cluster and its place in the binary tree of splits.
struct SplitNode
{
	SurfaceCluster cluster;
	uint32_t child = 0;  ///< the first of two children; 0 for a leaf
};

class Builder
{
public:
	Builder(const Mesh& mesh, int64_t elements) : m_wanted(size_t(elements))
	{
		std::vector<uint32_t> triangles;
		m_pieces = piecesOf(mesh, triangles);
		for (const SurfacePiece& p : m_pieces) m_elementArea += p.area / double(elements);
		m_regions = findFlatRegions(mesh, triangles, m_pieces, m_elementArea);
		if (m_pieces.empty()) return;
		std::vector<uint32_t> all(m_pieces.size());
		std::iota(all.begin(), all.end(), 0);
		addNode(std::move(all));
	}

	/// False if the caller cancelled.
	bool splitAll(const Progress& progress);
	/// Splits flat clusters whose parallelogram would stand out of their face, as those around a hole do. What is left of them is cut along
	/// the hole.
	void splitRims();
	const std::vector<SplitNode>& nodes() const { return m_nodes; }
	const std::vector<SurfacePiece>& pieces() const { return m_pieces; }

private:
	void addNode(std::vector<uint32_t> members);
	double outlineTolerance(const SurfaceCluster& cluster) const;
	FacePolygon outlineOf(const SurfaceCluster& cluster) const;
	void findFace(SurfaceCluster& cluster) const;
	bool isFinished(const SurfaceCluster& cluster) const;
	ClusterHalves halvesOf(const SurfaceCluster& cluster);
	void split(uint32_t index);

	using Waiting = std::pair<double, uint32_t>;  // priority, node
	struct Before
	{
		bool operator()(const Waiting& a, const Waiting& b) const { return a.first != b.first ? a.first < b.first : a.second > b.second; }
	};

	std::vector<SurfacePiece> m_pieces;
	std::vector<Vec3> m_regions;     ///< centroids of the flat regions [m]
	std::vector<SplitNode> m_nodes;  ///< a node's children follow each other
	std::priority_queue<Waiting, std::vector<Waiting>, Before> m_queue;
	size_t m_wanted, m_count = 0;  ///< elements
	double m_elementArea = 0;      ///< mean [m^2]
};

double priority(const SurfaceCluster& c)
{
	const double square = c.radius * c.radius, spread = c.spread(), apart = c.frame.thickness / square;
	const double bent = kSpreadWeight * spread * (1 + kWideSpreadWeight * spread * spread);
	return std::max(c.area, kSparse * square) * c.radius * (kSizeWeight + bent + kThicknessWeight * apart);
}

size_t elementsOf(const SurfaceCluster& c) { return c.face.empty() ? 1 : elementsOfPolygon(c.face); }

double Builder::outlineTolerance(const SurfaceCluster& c) const { return kOutline * std::min(std::sqrt(m_elementArea), c.radius); }

FacePolygon Builder::outlineOf(const SurfaceCluster& c) const { return convexFace(m_pieces, c, outlineTolerance(c)); }

/// A flat cluster keeps its outline if that does not take many more elements than its area is worth.
void Builder::findFace(SurfaceCluster& c) const
{
	if (!c.isFlat) return;
	c.face = outlineOf(c);
	const double worth = 1 + 2 * c.area / m_elementArea;
	if (c.pieces.size() > 1 && double(elementsOf(c)) > worth) c.face.clear();
}

/// Splitting the cluster gains nothing.
bool Builder::isFinished(const SurfaceCluster& c) const
{
	if (!c.isFlat) return false;
	if (c.face.empty()) return c.area < m_elementArea;
	const double* variance = c.frame.variance;
	const double length2 = 12 * variance[0];
	return variance[0] < kLongVariance * variance[1] || length2 < kLong * kLong * m_elementArea;
}

void Builder::addNode(std::vector<uint32_t> members)
{
	SplitNode node;
	node.cluster = clusterOf(m_pieces, std::move(members));
	findFace(node.cluster);
	m_count += elementsOf(node.cluster);
	if (!isFinished(node.cluster)) m_queue.push({priority(node.cluster), uint32_t(m_nodes.size())});
	m_nodes.push_back(std::move(node));
}

ClusterHalves Builder::halvesOf(const SurfaceCluster& c)
{
	const bool isCoarse = c.area > 0.5 * m_elementArea * double(c.pieces.size());
	const auto axes = cuttingAxes(c, !isCoarse && !c.isFlat);
	if (!c.face.empty()) return splitByPlane(m_pieces, nullptr, c, axes[0]);
	ClusterHalves halves;
	if (!c.isFlat)
	{
		const double mostLeft = isCoarse && c.pieces.size() <= kFew ? kFewLeft : c.spread() > kWideSpread ? kWideCrease : kCrease;
		halves = splitByNormals(m_pieces, c, mostLeft);
	}
	if (!halves.isProper() && isCoarse && (c.isFlat || c.slenderness < kSliver)) halves = splitWhole(m_pieces, m_regions, c, axes[0]);
	for (size_t i = 0; i < axes.size() && !halves.isProper(); ++i) halves = splitByPlane(m_pieces, &m_regions, c, axes[i]);
	if (!halves.isProper() && !c.isFlat) halves = splitByNormals(m_pieces, c, 1);
	return halves.isProper() ? halves : splitByPlane(m_pieces, nullptr, c, axes[0]);
}

void Builder::split(uint32_t index)
{
	ClusterHalves halves = halvesOf(m_nodes[index].cluster);
	if (!halves.isProper()) return;
	SurfaceCluster& parent = m_nodes[index].cluster;
	m_count -= elementsOf(parent);
	parent.pieces = {};
	parent.face = {};
	m_nodes[index].child = uint32_t(m_nodes.size());
	addNode(std::move(halves.first));
	addNode(std::move(halves.second));
}

bool Builder::splitAll(const Progress& progress)
{
	for (int splits = 0; m_count < m_wanted && !m_queue.empty(); ++splits)
	{
		if (splits % kSplitsPerReport == 0 && progress && !progress("surface", double(m_count) / double(m_wanted))) return false;
		const uint32_t index = m_queue.top().second;
		m_queue.pop();
		split(index);
	}
	return !progress || progress("surface", 1);
}

void Builder::splitRims()
{
	std::priority_queue<Waiting, std::vector<Waiting>, Before> rims;
	const auto add = [&](uint32_t index) {
		SplitNode& node = m_nodes[index];
		if (node.child || !node.cluster.isFlat || !node.cluster.face.empty() || node.cluster.pieces.size() < 2) return;
		const double area = overreach(m_pieces, node.cluster);
		if (area > kRim * m_elementArea) return rims.push({area, index});
		node.cluster.face = outlineOf(node.cluster);
		m_count += elementsOf(node.cluster) - 1;
	};
	for (uint32_t i = 0; i < m_nodes.size(); ++i) add(i);
	while (!rims.empty() && double(m_count) < kMostWithRims * double(m_wanted))
	{
		const uint32_t index = rims.top().second;
		rims.pop();
		split(index);
		if (const uint32_t child = m_nodes[index].child)
			for (const uint32_t i : {child, child + 1}) add(i);
	}
	for (SplitNode& node : m_nodes)
		if (!node.child && node.cluster.isFlat && node.cluster.face.empty())
			node.cluster.face = faceWithin(m_pieces, node.cluster, outlineTolerance(node.cluster));
}

/// Writes the nodes and elements of the tree in depth-first order, and widens the balls so that they hold the sheets.
class Writer
{
public:
	explicit Writer(const Builder& builder) : m_builder(builder) {}
	ContactSurface write();

private:
	struct Task
	{
		uint32_t to;        ///< node that is written
		uint32_t from = 0;  ///< node of the builder
		FacePolygon face;   ///< if not empty: the part of a face that is written instead
	};
	void writeNode(const Task& task);
	void writeFace(const Task& task);
	uint32_t addChildren(uint32_t parent);
	void setBall(uint32_t node, const Vec3& center, double radius);
	void setElement(uint32_t node, const SurfaceElement& element);

	const Builder& m_builder;
	std::vector<SurfaceNode> m_nodes;
	std::vector<uint32_t> m_parents;
	std::vector<SurfaceElement> m_elements;
	std::vector<Task> m_tasks;  ///< last in, first out
};

/// The smallest float that is safely larger.
float above(double radius) { return std::nextafter(float(radius * (1 + 1e-7)), std::numeric_limits<float>::infinity()); }

uint32_t Writer::addChildren(uint32_t parent)
{
	const uint32_t child = uint32_t(m_nodes.size());
	m_nodes.resize(child + 2);
	m_parents.resize(child + 2, parent);
	m_nodes[parent].child = child;
	return child;
}

void Writer::setBall(uint32_t node, const Vec3& center, double radius)
{
	SurfaceNode& n = m_nodes[node];
	n.center[0] = float(center.x), n.center[1] = float(center.y), n.center[2] = float(center.z);
	n.radius = above(radius + distance(center, toVec3(n.center)));
}

void Writer::setElement(uint32_t node, const SurfaceElement& element)
{
	m_nodes[node].child = uint32_t(m_elements.size()) | SurfaceNode::kElement;
	m_elements.push_back(element);
	const auto points = controlPoints(element);
	for (uint32_t n = node;; n = m_parents[n])
	{
		double radius = m_nodes[n].radius;
		for (const Vec3& p : points) radius = std::max(radius, distance(p, toVec3(m_nodes[n].center)));
		if (radius > m_nodes[n].radius) m_nodes[n].radius = above(radius);
		if (n == 0) return;
	}
}

void Writer::writeFace(const Task& task)
{
	const SurfaceCluster& c = m_builder.nodes()[task.from].cluster;
	Vec3 center;
	double radius = 0;
	for (const Vec3& p : task.face) center += p / double(task.face.size());
	for (const Vec3& p : task.face) radius = std::max(radius, distance(p, center));
	// The whole face has the cluster's ball, which also holds the corners that were left out.
	if (task.face.size() == c.face.size()) setBall(task.to, c.ballCenter, c.ballRadius);
	else setBall(task.to, center, radius);
	if (elementsOfPolygon(task.face) == 1)
	{
		setElement(task.to, elementOfFace(task.face, c.frame.normal, c.area * areaOfPolygon(task.face) / areaOfPolygon(c.face)));
		return;
	}
	auto [first, second] = halvesOfPolygon(task.face);
	const uint32_t child = addChildren(task.to);
	m_tasks.push_back({child + 1, task.from, std::move(second)});
	m_tasks.push_back({child, task.from, std::move(first)});
}

void Writer::writeNode(const Task& task)
{
	const SplitNode& node = m_builder.nodes()[task.from];
	const SurfaceCluster& c = node.cluster;
	if (!node.child && !c.face.empty()) return writeFace({task.to, task.from, c.face});
	setBall(task.to, c.ballCenter, c.ballRadius);
	if (!node.child) return setElement(task.to, sheetOfCluster(m_builder.pieces(), c));
	const uint32_t child = addChildren(task.to);
	m_tasks.push_back({child + 1, node.child + 1, {}});
	m_tasks.push_back({child, node.child, {}});
}

ContactSurface Writer::write()
{
	m_nodes.resize(1);
	m_parents.resize(1);
	for (m_tasks.push_back({0, 0, {}}); !m_tasks.empty();)
	{
		const Task task = std::move(m_tasks.back());
		m_tasks.pop_back();
		if (task.face.empty()) writeNode(task);
		else writeFace(task);
	}
	ContactSurface surface;
	surface.nodes = std::move(m_nodes);
	surface.elements = std::move(m_elements);
	return surface;
}
}  // namespace

Result<ContactSurface> buildContactSurface(const Mesh& mesh, const ContactSurfaceOptions& options)
{
	if (!std::isfinite(surfaceArea(mesh))) return Error{"The mesh has coordinates that are not finite. Repair the mesh first."};
	Builder builder(mesh, std::clamp(options.elements, kFewestElements, kMostElements));
	if (builder.pieces().empty()) return Error{"The mesh has no triangle with an area, so it has no surface. Check the mesh and its unit."};
	if (!builder.splitAll(options.progress)) return Error{"The build of the surface was cancelled.", true};
	builder.splitRims();
	return Writer(builder).write();
}
}  // namespace ist
