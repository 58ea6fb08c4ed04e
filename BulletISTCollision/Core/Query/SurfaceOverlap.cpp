// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/SurfaceOverlap.h"

#include "BulletISTCollision/Core/Faces/ContactNormals.h"
#include "BulletISTCollision/Core/Faces/DepthIntegral.h"
#include "BulletISTCollision/Core/Faces/FaceParts.h"
#include "BulletISTCollision/Core/Faces/FaceVolume.h"
#include "BulletISTCollision/Core/Faces/Foundation.h"
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ist
{
using namespace kernels;

namespace
{
/// A part of a contact has at least this share of the volume that its depths say, whatever its faces enclose.
constexpr double kLeastOfColumns = 0.3;
/// How much more than its own error says the volume that faces enclose is trusted to be off, as a factor of the variance: the gaps along a
/// rim err alike.
constexpr double kGapsErrAlike = 9;
/// The damping of columns is scaled to the volume by at most this factor.
constexpr double kMostOfColumns = 4;
/// Share of a pressure below which it has no direction, and the rank of such a face (PairStream::Rank).
constexpr double kNoDirection = 0.1, kLeastRank = 0.001;
/// An error of a cell below this share of its radius is that of rounding: the depth is that of a plane.
constexpr double kRounding = 1e-7;

void toFrame(const Pose& X, ContactFace& face)
{
	face.center = X * face.center;
	face.pressureCenter = X * face.pressureCenter;
	face.areaNormal = X.rotation * face.areaNormal;
	face.pressure = X.rotation * face.pressure;
	face.gradient = X.rotation * face.gradient;
	face.spread = X.rotation * face.spread * transpose(X.rotation);
	face.second = rotated(X.rotation, face.second);
}

/// Volume of the columns from the face along the depth's gradient to the other body's surface [m^3]; too small where these lines
/// come from an edge or from the medial axis. Negative where the body lies on the face's far side from there: the sum over the faces
/// of one body is at most the volume, as depths are concave.
double columnVolume(const ContactFace& face) { return dot(face.pressure, face.gradient); }

void addSquare(double (&m)[6], const Vec3& x, double w)
{
	const double s[6] = {x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.x * x.z, x.y * x.z};
	for (int i = 0; i < 6; ++i) m[i] += w * s[i];
}

/// K += w sym(a b^T) for twists or wrenches a and b.
void addSymmetric(SymmetricMatrix6& K, const double (&a)[6], const double (&b)[6], double w)
{
	for (int i = 0, entry = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) K.m[entry++] += 0.5 * w * (a[i] * b[j] + a[j] * b[i]);
}

/// K += w sym(Int (y x a) (y x b)^T dS), which a face adds to the stiffness of rotations about its own center. J = Int y y^T dS.
void addSpin(SymmetricMatrix6& K, const SymmetricMatrix3& J, const Vec3& a, const Vec3& b, double w)
{
	const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, rows[3] = {{J.xx, J.xy, J.xz}, {J.xy, J.yy, J.yz}, {J.xz, J.yz, J.zz}};
	double m[3][3] = {};
	for (int k = 0; k < 3; ++k)
	{
		const Vec3 u = cross(axes[k], a), v = cross(rows[k], b);
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) m[i][j] += u[i] * v[j];
	}
	for (int i = 0; i < 3; ++i)
		for (int j = i; j < 3; ++j) K(3 + i, 3 + j) += 0.5 * w * (m[i][j] + m[j][i]);
}

/// Volume of the columns of a face, with the weight of the body whose depth presses there.
double weightedColumns(const ContactFace& face, double sign, const DampingWeights& weights)
{
	return (sign > 0 ? weights.A : weights.B) * std::max(columnVolume(face), 0.0);
}

/// Adds what a face says of forces, stiffness and damping; everything but the volume. `sign`: 1 for a face of B, -1 for one of A.
void addFace(OverlapIntegrals& sums, const ContactFace& face, double sign, const ContactNormals& normals, const DampingWeights& weights)
{
	const Vec3 &x = face.center, &p = face.pressureCenter;
	const Vec3 slides = normals.at(face, sign), n = normals.along(face.areaNormal, slides), g = normals.along(face.gradient, slides);
	Wrench& normal = sign > 0 ? sums.normalA : sums.normalB;
	normal.force -= face.pressure;
	normal.torque -= cross(p, face.pressure);
	(sign > 0 ? sums.pressedA : sums.pressedB) += norm(face.pressure);
	sums.areaVector += (0.5 * sign) * face.areaNormal;
	const Vec3 tn = cross(x, n), tg = cross(x, g);
	const double G[6] = {n.x, n.y, n.z, tn.x, tn.y, tn.z}, H[6] = {g.x, g.y, g.z, tg.x, tg.y, tg.z};
	SymmetricMatrix6& stiffness = sign > 0 ? sums.stiffnessA : sums.stiffnessB;
	addSymmetric(stiffness, G, H, 1);
	// Along a curved face the normal turns, and takes back what the way from the center adds: a screw slides along its thread. Where the
	// face presses along the normals of the other body, these do not turn.
	const bool areOfOther = sign > 0 ? normals.areOfA() : normals.areOfB();
	const bool isPlane = isFlat(face) || normals.areFlat() || areOfOther;
	if (isPlane) addSpin(stiffness, face.second, n, g, 1 / face.area);
	// The body whose depth presses moves along its own normals, which the depth's gradient has all along the columns below the face.
	const double weight = weightedColumns(face, sign, weights);
	if (weight > 0)
	{
		const Vec3 tp = cross(p, g);
		const double P[6] = {g.x, g.y, g.z, tp.x, tp.y, tp.z};
		addSymmetric(sums.damping, P, P, weight);
		if (isPlane) addSpin(sums.damping, face.second, g, g, weight / face.area);
	}
	++sums.pairs;
}

/// Moments of the places where a patch presses, and the weighted volume of its columns.
struct PressedPlaces
{
	double depth = 0, damped = 0, area = 0, second[6] = {};
	Vec3 first;

	void add(const ContactFace& face, double share)
	{
		depth += share * face.depth;
		first += share * face.depth * face.pressureCenter;
		addSquare(second, face.pressureCenter, share * face.depth);
		addOwn(face, share * face.depth / face.area);
	}
	void addOwn(const ContactFace& face, double weight)
	{
		const SymmetricMatrix3& s = face.second;
		const double own[6] = {s.xx, s.yy, s.zz, s.xy, s.xz, s.yz};
		for (int i = 0; i < 6; ++i) second[i] += weight * own[i];
	}
	/// A face on a foundation counts with the middle of its column, so that the sums are those of the volume.
	void addColumn(const ContactFace& face, double share)
	{
		const double column = share * columnVolume(face), mean = face.depth / face.area;
		const double length = std::clamp(mean + dot(face.gradient, face.pressureCenter - face.center), mean, 2 * mean);
		const Vec3 middle = face.pressureCenter - 0.5 * length * face.gradient;
		depth += column;
		first += column * middle;
		addSquare(second, middle, column);
		addOwn(face, column / face.area);
	}
	void addTo(OverlapIntegrals& sums) const
	{
		if (!(depth > 0)) return;
		const double share = sums.volume / depth;
		sums.firstMoment = share * first;
		for (int i = 0; i < 6; ++i) sums.secondMoment[i] = share * second[i];
		// Columns are too small where their lines spread.
		const double both = sums.dampingWeights.A + sums.dampingWeights.B;
		if (!(damped > 0)) return;
		const double scale = std::min(both * both * sums.volume / damped, kMostOfColumns);
		for (double& m : sums.damping.m) m *= scale;
	}
};

/// Volume and depth of a part of the overlap that hangs together: it may be several patches.
struct OverlapPart
{
	FaceVolume form;
	double volume = 0, depth = 0;
	double columnsOfA = 0, columnsOfB = 0;  ///< volumes of the columns on faces of A and of B
	double placed = 0;                      ///< sum of the depths of places
	double flush = 0;                       ///< area of faces that lie in the other surface: columns do not know their volume
	double variance = 0;                    ///< of the volume
	Vec3 normalA, normalB;                  ///< integrals of the normals [m^3]
	double withinA = 1, withinB = 1;        ///< shares of them that count
	DepthIntegral depths;
	bool hasCones = false;

	double columns() const { return 0.5 * (columnsOfA + columnsOfB); }
	/// Joins what the faces enclose with the columns between them. Columns are exact where the two surfaces lie along each other, and say
	/// so: those of both bodies are equal then, and as large as the depth.
	void joinColumns()
	{
		const double ofForm = kGapsErrAlike * form.inexactVariance();
		const double off = 0.5 * std::fabs(columnsOfB - columnsOfA) + std::fabs(0.5 * depth - columns()) + flush * std::sqrt(form.area());
		const double sum = ofForm + off * off, share = sum > 0 ? ofForm / sum : 0;
		volume = std::max({volume + share * (columns() - volume), kLeastOfColumns * columns(), 0.0});
		variance = (1 - share) * (1 - share) * form.variance() + share * share * off * off;
	}
	/// On a foundation the columns on the other body's faces are the volume.
	void takeColumns(double share, double columnsOfOther)
	{
		if (share == 0) return;
		volume += share * (std::max(columnsOfOther, 0.0) - volume);
		variance += share * (form.variance() - variance);
	}
	/// Share of an integral of normals that is no larger than the volume, as no integral of unit normals can be. Where a contact is
	/// shallower than the errors of a depth field, its volume is more exact.
	double within(const Vec3& normals) const { return norm(normals) > volume ? volume / norm(normals) : 1; }
};
}  // namespace

struct SurfaceWorkspace::Implementation
{
	FaceList ofA, ofB;
	PatchGrouper grouper;
	DemandZeroArray<uint32_t> a, b;
	DemandZeroArray<float> numbers;
	PairStream stream{};
	std::vector<OverlapIntegrals> patches;
	std::vector<PressedPlaces> places;
	std::vector<OverlapPart> parts;  ///< of each patch; valid for the first patch of a part
	std::vector<uint32_t> partOf;    ///< first patch of the part of each patch
	FaceParts faceParts;
	std::vector<ContactNormals> normals;    ///< of each part of the faces; the last stands for all further parts, and has none
	DemandZeroArray<uint32_t> firstOfPart;  ///< first patch that was found for each part of the faces
	ConePoints cones;
	const QueryKernel* kernel = nullptr;

	/// A part has a point more than it has faces.
	Implementation(size_t faces, size_t mostParts)
		: faceParts(2 * faces),
		  normals(mostParts + 1),
		  firstOfPart(2 * faces),
		  cones(2 * faces + mostParts)
	{}

	ContactNormals& normalsOf(uint32_t part) { return normals[std::min(size_t(part), normals.size() - 1)]; }
};

SurfaceWorkspace::SurfaceWorkspace(size_t faces, int patches, const kernels::QueryKernel* kernel)
	: m_impl(std::make_unique<Implementation>(faces, size_t(std::max(1, patches))))
{
	Implementation& w = *m_impl;
	w.kernel = kernel ? kernel : &kPortableKernel;
	w.ofA.faces = DemandZeroArray<ContactFace>(faces);
	w.ofB.faces = DemandZeroArray<ContactFace>(faces);
	const size_t both = 2 * faces + kListSlack;
	w.a = DemandZeroArray<uint32_t>(both);
	w.b = DemandZeroArray<uint32_t>(both);
	w.numbers = DemandZeroArray<float>(both * PairStream::ColumnCount);
	w.stream = {w.a.data(), w.b.data(), w.numbers.data(), both};
	w.patches.resize(size_t(std::max(1, patches)));
	w.places.resize(w.patches.size());
	w.parts.resize(w.patches.size());
	w.partOf.resize(w.patches.size());
	w.grouper.reserve(2 * faces, 2 * faces, int(w.patches.size()));
}

SurfaceWorkspace::~SurfaceWorkspace() = default;

void SurfaceWorkspace::makeResident()
{
	Implementation& w = *m_impl;
	w.ofA.faces.touch();
	w.ofB.faces.touch();
	w.a.touch();
	w.b.touch();
	w.numbers.touch();
	w.faceParts.makeResident();
	w.firstOfPart.touch();
	w.grouper.makeResident();
	w.cones.makeResident();
}

namespace
{
/// How far the surface may be off at a face: the errors of its own description and of the other body's depth [m].
double errorOf(const ContactSurface& surface, const DepthField& field, const ContactFace& face)
{
	const DepthCell& cell = field.cells[face.cell];
	const double ofSurface = surface.elements[face.element].error, ofField = cell.error > kRounding * cell.radius ? cell.error : 0;
	return std::sqrt(ofSurface * ofSurface + ofField * ofField);
}

/// Share of a face in the variance of the force for 1 Pa/m [m^6]. All faces in one cell of the field have the cell's error together.
/// `area`: of all faces that hang together.
double forceVariance(const DepthField& field, const ContactFace& face, double area)
{
	const DepthCell& cell = field.cells[face.cell];
	const double ofCell = std::min(area, std::numbers::pi * double(cell.radius) * cell.radius);
	const double shared = double(cell.error) * cell.error * std::max(0.0, ofCell - face.area);
	return face.area * (face.error * face.error * face.area + shared);
}

FaceCounts sumOf(const FaceCounts& a, const FaceCounts& b)
{
	return {a.nodes + b.nodes, a.elements + b.elements, a.quarters + b.quarters, a.planes + b.planes, a.cuts + b.cuts, a.cells + b.cells,
		a.halvings + b.halvings};
}

/// What one field presses.
struct FieldSums
{
	Wrench& normal;
	double &pressed, &depth;
	SymmetricMatrix6& stiffness;
};

FieldSums sumsOfA(OverlapIntegrals& sums) { return {sums.normalA, sums.pressedA, sums.depthA, sums.stiffnessA}; }
FieldSums sumsOfB(OverlapIntegrals& sums) { return {sums.normalB, sums.pressedB, sums.depthB, sums.stiffnessB}; }

/// Moves what the other field presses towards what the foundation does.
void lean(double share, const FieldSums& foundation, const FieldSums& other)
{
	if (share == 0) return;
	other.normal = (1 - share) * other.normal - share * foundation.normal;
	other.pressed += share * (foundation.pressed - other.pressed);
	other.depth += share * (foundation.depth - other.depth);
	for (int i = 0; i < 21; ++i) other.stiffness.m[i] += share * (foundation.stiffness.m[i] - other.stiffness.m[i]);
}

/// Groups the faces of both bodies into parts that hang together, and these into patches.
class FaceGrouping
{
public:
	FaceGrouping(SurfaceWorkspace::Implementation& work, const BodySurface& A, const BodySurface& B, int most)
		: m_work(work),
		  m_hasFaces{!A.surface.elements.empty(), !B.surface.elements.empty()},
		  m_most(std::min(most, int(work.patches.size())))
	{}

	/// Returns the number of patches. Sets the normals of each part, and the first patch of the part of each patch.
	int group()
	{
		FaceParts& parts = m_work.faceParts;
		parts.clear();
		forAll([&](const ContactFace& face, double) { parts.add(face); });
		const uint32_t count = parts.find();
		const auto forNormals = [&](const auto& function) {
			for (size_t part = 0; part < std::min(size_t(count), m_work.normals.size() - 1); ++part) function(m_work.normals[part]);
		};
		forNormals([](ContactNormals& normals) { normals.clear(); });
		m_work.normals.back().clear();
		const PairStream& s = m_work.stream;
		m_count = 0;
		// A pair of the grouper is a face, and both of its balls are the part of the face.
		forAll([&](const ContactFace& face, double sign) {
			const uint32_t part = parts.of(size_t(m_count));
			s.a[m_count] = s.b[m_count] = part;
			m_work.normalsOf(part).add(face, sign);
			++m_count;
		});
		forNormals([&](ContactNormals& normals) { normals.find(m_hasFaces[0], m_hasFaces[1]); });
		m_count = 0;
		forAll([&](const ContactFace& face, double sign) { normalsOf(m_count++).measure(face, sign); });
		forNormals([](ContactNormals& normals) { normals.settle(); });
		m_count = 0;
		forAll([&](ContactFace& face, double sign) { enter(face, sign); });
		const int patches = m_work.grouper.group(*m_work.kernel, s, m_count, 0, m_most);
		findFirstPatches(count);
		return patches;
	}

private:
	template <class Function> void forAll(const Function& function)
	{
		for (size_t i = 0; i < m_work.ofB.count; ++i) function(m_work.ofB.faces[i], 1.0);
		for (size_t i = 0; i < m_work.ofA.count; ++i) function(m_work.ofA.faces[i], -1.0);
	}

	ContactNormals& normalsOf(int face) { return m_work.normalsOf(m_work.stream.a[face]); }

	void enter(ContactFace& face, double sign)
	{
		const ContactNormals& normals = normalsOf(m_count);
		const Vec3 normal = normals.at(face, sign);
		face.pressure = normals.pressure(face, sign, normal);
		const PairStream& s = m_work.stream;
		const double size = norm(face.pressure);
		const bool directed = size > kNoDirection * face.depth;
		// Faces that look back belong to the same patch.
		const Vec3 force = normals.exist() ? size * normal : sign * face.pressure;
		for (int i = 0; i < 3; ++i)
		{
			columnOf(s, PairStream::Force + i)[m_count] = float(force[i]);
			columnOf(s, PairStream::Centroid + i)[m_count] = float(face.center[i]);
		}
		columnOf(s, PairStream::Size)[m_count] = directed ? float(size) : 0;
		columnOf(s, PairStream::Rank)[m_count] = float(std::max(size, kLeastRank * face.depth));
		++m_count;
	}

	/// A patch may hold faces of several parts where there are more parts than patches; they count as one part.
	void findFirstPatches(uint32_t parts)
	{
		DemandZeroArray<uint32_t>& first = m_work.firstOfPart;
		std::vector<uint32_t>& partOf = m_work.partOf;
		const float* patchOf = m_work.grouper.patch();
		for (uint32_t part = 0; part < parts; ++part) first[part] = UINT32_MAX;
		for (uint32_t p = 0; p < uint32_t(m_work.patches.size()); ++p) partOf[p] = p;
		const auto root = [&](uint32_t p) {
			while (partOf[p] != p) p = partOf[p];
			return p;
		};
		for (int i = 0; i < m_count; ++i)
		{
			uint32_t& f = first[m_work.faceParts.of(size_t(i))];
			const uint32_t p = root(uint32_t(patchOf[i]));
			if (f == UINT32_MAX) f = p;
			const uint32_t q = root(f);
			partOf[std::max(p, q)] = std::min(p, q);
		}
		for (uint32_t p = 0; p < uint32_t(m_work.patches.size()); ++p) partOf[p] = root(p);
	}

	SurfaceWorkspace::Implementation& m_work;
	bool m_hasFaces[2];  // of A, of B
	int m_most;          // patches
	int m_count = 0;
};
}  // namespace

SurfaceOverlap surfaceOverlap(const BodySurface& A, const BodySurface& B, const Pose& X_AB, SurfaceWorkspace& workspace,
	const DampingWeights& damping, int mostPatches, int64_t mostFaces)
{
	SurfaceWorkspace::Implementation& work = workspace.implementation();
	const Pose X_BA = inverse(X_AB);
	SurfaceOverlap result;
	work.ofB.clear(mostFaces);
	collectFaces(B, A, X_AB, *work.kernel, work.ofB);
	work.ofA.clear(mostFaces < 0 ? -1 : mostFaces - int64_t(work.ofB.count));
	if (!work.ofB.isOverLimit()) collectFaces(A, B, X_BA, *work.kernel, work.ofA);
	result.counts = sumOf(work.ofA.counts, work.ofB.counts);
	result.isOverLimit = work.ofA.isOverLimit() || work.ofB.isOverLimit();
	if (result.isOverLimit) return result;
	for (size_t i = 0; i < work.ofB.count; ++i) work.ofB.faces[i].error = errorOf(B.surface, A.field, work.ofB.faces[i]);
	for (size_t i = 0; i < work.ofA.count; ++i)
	{
		toFrame(X_AB, work.ofA.faces[i]);
		work.ofA.faces[i].error = errorOf(A.surface, B.field, work.ofA.faces[i]);
	}
	const Foundation onB(B, A, work.ofA, work.ofB);
	Foundation onA(A, B, work.ofB, work.ofA);
	onA.leaveOut(onB);
	const double loose = 1 - onA.volume - onB.volume;
	DampingWeights weights = damping;
	leanWeights(onA.pressure, onB.pressure, weights.A, weights.B);

	const auto forAll = [&](const auto& function) {
		for (size_t i = 0; i < work.ofB.count; ++i) function(work.ofB.faces[i], i, 1.0);
		for (size_t i = 0; i < work.ofA.count; ++i) function(work.ofA.faces[i], work.ofB.count + i, -1.0);
	};
	const int patches = FaceGrouping(work, A, B, mostPatches).group();
	const float* patchOf = work.grouper.patch();
	for (size_t p = 0; p < size_t(patches); ++p)
	{
		work.patches[p] = {};
		work.patches[p].dampingWeights = damping;
		work.places[p] = {};
		work.parts[p] = {};
	}
	const auto partOf = [&](size_t index) -> OverlapPart& { return work.parts[work.partOf[size_t(patchOf[index])]]; };
	forAll([&](const ContactFace& face, size_t index, double) { partOf(index).form.addArea(face); });
	for (size_t p = 0; p < size_t(patches); ++p) work.parts[p].form.fit();
	forAll([&](const ContactFace& face, size_t index, double) { partOf(index).form.add(face); });
	for (size_t p = 0; p < size_t(patches); ++p)
	{
		work.parts[p].form.finish();
		work.parts[p].volume = work.parts[p].form.volume();
		work.parts[p].depths.begin();
	}
	forAll([&](const ContactFace& face, size_t index, double sign) {
		const size_t p = size_t(patchOf[index]);
		const ContactNormals& normals = work.normalsOf(work.faceParts.of(index));
		addFace(work.patches[p], face, sign, normals, weights);
		if (normals.areOfA()) work.patches[p].slidingVolumeA += normals.share() * face.area;
		if (normals.areOfB()) work.patches[p].slidingVolumeB += normals.share() * face.area;
		work.places[p].area += face.area;
		work.patches[p].forceVariance += forceVariance(sign > 0 ? A.field : B.field, face, partOf(index).form.area());
		work.places[p].damped += weightedColumns(face, sign, weights);
		const double founded = sign < 0 ? onB.volume : onA.volume;
		if (loose > 0) work.places[p].add(face, loose);
		if (founded > 0) work.places[p].addColumn(face, founded);
		OverlapPart& part = partOf(index);
		(sign < 0 ? part.columnsOfA : part.columnsOfB) += columnVolume(face);
		if (face.cut > face.area) part.flush += face.area;
		part.depth += face.depth;
		part.depths.addColumn(face, sign > 0);
	});
	const auto forParts = [&](const auto& function) {
		for (size_t p = 0; p < size_t(patches); ++p)
			if (work.partOf[p] == p) function(work.parts[p], uint32_t(p));
	};
	work.cones.clear(X_BA);
	forParts([&](OverlapPart& part, uint32_t number) {
		part.joinColumns();
		part.takeColumns(onB.volume, part.columnsOfA);
		part.takeColumns(onA.volume, part.columnsOfB);
		part.hasCones = part.depths.needsCones(part.volume);
		if (part.hasCones) part.depths.beginCones(part.form.centroid(), part.form.area(), number, work.cones);
	});
	if (work.cones.count() > 0)
	{
		forAll([&](const ContactFace& face, size_t index, double sign) {
			OverlapPart& part = partOf(index);
			if (part.hasCones) part.depths.addCone(face, sign > 0, work.cones);
		});
		forParts([&](OverlapPart& part, uint32_t) {
			if (part.hasCones) part.depths.finishCones(work.cones);
		});
		work.cones.sample(A, B, *work.kernel);
		for (size_t i = 0; i < work.cones.count(); ++i) work.parts[work.cones.part(i)].depths.addSample(work.cones, i);
	}
	forParts([&](OverlapPart& part, uint32_t) { part.depths.finish(part.volume); });
	for (size_t p = 0; p < size_t(patches); ++p)
	{
		OverlapPart& part = work.parts[work.partOf[p]];
		part.normalA += work.patches[p].normalA.force;
		part.normalB += work.patches[p].normalB.force;
		part.placed += work.places[p].depth;
	}
	forParts([](OverlapPart& part, uint32_t) {
		part.withinA = part.within(part.normalA);
		part.withinB = part.within(part.normalB);
	});
	const auto press = [&](ContactFace& face, size_t index, double sign) {
		face.pressure *= sign > 0 ? partOf(index).withinA : partOf(index).withinB;
	};
	forAll(press);
	for (size_t p = 0; p < size_t(patches); ++p)
	{
		const OverlapPart& part = work.parts[work.partOf[p]];
		OverlapIntegrals& patch = work.patches[p];
		patch.normalA = part.withinA * patch.normalA;
		patch.normalB = part.withinB * patch.normalB;
		patch.pressedA *= part.withinA;
		patch.pressedB *= part.withinB;
		const double share = part.placed > 0 ? work.places[p].depth / part.placed : 1;
		patch.volume = patch.surfaceVolume = share * part.volume;
		const double perArea = work.places[p].area > 0 ? patch.volume / work.places[p].area : 0;
		patch.slidingVolumeA *= perArea;
		patch.slidingVolumeB *= perArea;
		patch.volumeVariance = share * part.variance;
		patch.depthA = share * part.depths.ofA();
		patch.depthB = share * part.depths.ofB();
		work.places[p].addTo(patch);
		lean(onB.pressure, sumsOfB(patch), sumsOfA(patch));
		lean(onA.pressure, sumsOfA(patch), sumsOfB(patch));
		result.total.add(patch);
	}
	result.total.dampingWeights = damping;
	result.patches = work.patches.data();
	result.patchCount = patches;
	result.ofA = work.ofA.faces.data();
	result.ofB = work.ofB.faces.data();
	result.countA = work.ofA.count;
	result.countB = work.ofB.count;
	result.leanOnA = onA.pressure;
	result.leanOnB = onB.pressure;
	result.dropped = work.ofA.dropped + work.ofB.dropped;
	return result;
}
}  // namespace ist
