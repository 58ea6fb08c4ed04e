// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/InstructionSet.h"
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <cstddef>
#include <memory>

namespace ist
{
struct ContactFace;

/// Symmetric 6x6 matrix, linear part first, row-major upper triangle (21 entries).
struct SymmetricMatrix6
{
	double m[21] = {};
	static constexpr int index(int i, int j) { return i <= j ? i * (11 - i) / 2 + j : index(j, i); }
	double operator()(int i, int j) const { return m[index(i, j)]; }
	double& operator()(int i, int j) { return m[index(i, j)]; }
};

/// Weights of the two pressure fields in `OverlapIntegrals::damping`. Neither may be negative. With both 0, `damping` stays zero.
struct DampingWeights
{
	double A = 0, B = 0;
};
inline bool operator==(const DampingWeights& a, const DampingWeights& b) { return a.A == b.A && a.B == b.B; }
inline bool operator!=(const DampingWeights& a, const DampingWeights& b) { return !(a == b); }

/// Integrals over the overlap of A and B, or over one patch of it. Only `damping` depends on the materials, through its weights.
/// All vectors have the axes of A's mesh frame. Moments are taken about A's `origin`, its centre of mass.
/// The sums run over the pairs of a ball i of A and a ball j of B. Derivation: docs/model.md, section 3.
/// - dd = d_i d_j, the product of the two densities.
/// - L: volume of the lens, which is the intersection of two ellipsoids of density 1 (Lens.h), or of two balls with Model::Inner.
/// - C: centroid of the lens.
/// - q: mean depth of the ball under the surface of its body [m].
/// - m: mean outward normal at C. A leaf has one normal, m(c); the normal of a merged ball changes over it (NormalGradient).
/// - area n: the negative gradient of L by c_i - c_j; n has unit length.
/// Where surfaces answer (QueryOptions), the integrals are those of the bodies, by Gauss's theorem over the faces (docs/model.md, section
/// 3).
struct OverlapIntegrals
{
	double volume = 0;            ///< sum dd L [m^3]
	Vec3 firstMoment;             ///< sum dd L C [m^4]
	double secondMoment[6] = {};  ///< sum dd L C C^T: xx, yy, zz, xy, xz, yz [m^5]; for friction
	Wrench normalA, normalB;      ///< forces sum dd L m_i and sum dd L m_j, torques sum C x (dd L m): Int n_A dV, Int n_B dV
	/// Sums over faces of the sizes of their shares of normalA.force and normalB.force [m^3]: larger than the sizes of these where the
	/// surface that presses is curved. Zero of leaves.
	double pressedA = 0, pressedB = 0;
	Wrench line;      ///< force sum dd L n, torque sum C x (dd L n): the paper's eq. (1) at rest; only with Model::Inner
	Vec3 areaVector;  ///< sum dd area n [m^2]: gradient of V, pointing where A must move to leave B
	SymmetricMatrix6 stiffnessA, stiffnessB;  ///< sum dd area sym(g_n g_w^T) with w = -m_i (A's field), w = m_j (B's field); not projected
	/// sum dd L G G^T with w = w_B m_j - w_A m_i, the direction in which the pair presses, and G = (w, C x w). For a twist of A it
	/// gives the squared closing speed of the pair, weighted with its pressure [m^3, m^4, m^5]. It is zero where `dampingWeights`
	/// are zero. With surfaces, w is the normal of either body, with its weight.
	SymmetricMatrix6 damping;
	DampingWeights dampingWeights;
	double depthA = 0, depthB = 0;  ///< sum dd L (q_i - m_i(c_i).(C - c_i)), and the sum with j for i: Int depth dV [m^4]
	double surfaceVolume = 0;       ///< part of `volume` that comes from surfaces [m^3]; leaves gave the rest
	/// Parts of `surfaceVolume` that press along the normals of A or of B, over which the other slides (ContactNormals.h): the stiffness
	/// leaves out that these turn with it, as that of leaves does [m^3].
	double slidingVolumeA = 0, slidingVolumeB = 0;
	/// Squared errors of the surfaces' part, for the error bar [m^6]: of the force for 1 Pa/m, the sum over faces of (area times error of
	/// the surface)^2, where all faces in one cell of the field share its error; and of the volume, which adds those of the cuts where the
	/// surfaces cross.
	double forceVariance = 0, volumeVariance = 0;
	int64_t pairs = 0;  ///< number of intersecting pairs of balls, or of faces

	void add(const OverlapIntegrals& other);
	/// Multiplies everything by `factor`, except the number of pairs.
	void scale(double factor);
};

/// A face of a surface takes as long as this many pairs of leaves. Budgets count it so.
constexpr int64_t kPairsPerFace = 12;
/// Time of the query that gave the integrals, in pairs of leaves.
inline int64_t costInPairs(const OverlapIntegrals& integrals)
{
	return (integrals.surfaceVolume > 0 ? kPairsPerFace : 1) * integrals.pairs;
}

/// What represents a body in a query.
enum class Model
{
	/// Surfaces, where both bodies have one and the query is for the finest level; otherwise leaves (default). Half-spaces and boxes have
	/// one.
	Law,
	Leaf,  ///< leaves
	Cell,  ///< unsplit cells: the most accurate volume
	Inner  ///< packed spheres: a lower bound of the volume; their normals and depths count as zero
};

enum class QueryStatus
{
	Ok,
	InvalidPose,  ///< the pose is not finite or not rigid, or the analytic field is invalid; the rest of the result is untouched
	EmptyTree,    ///< a body has no tree for the model
	/// The options contradict each other, the two bodies lack the level, or a level or budget is used with an analytic field.
	Unsupported,
	BudgetTooSmall,  ///< the coarsest level has more pairs than `maxPairs`, so there is no answer
	InstructionSet   ///< this machine cannot run the set that BULLETHAPTICS_ISA or the workspace's constructor names
};
const char* toString(QueryStatus status);

struct QueryOptions
{
	Model model = Model::Law;
	/// Level of the trees: -1 or 0 means the leaves. Each further step reduces the larger of the two trees to a third of its balls.
	/// Only with Model::Law.
	int level = -1;
	/// Pair budget, if not negative. The answer comes from the finest level found, from `level` on, that has at most this many
	/// intersecting pairs; of surfaces, at most a kPairsPerFace-th of it faces. A few levels are tried, and each traversal ends at the
	/// budget. Together they find less than three times the budget. Only with Model::Law.
	int64_t maxPairs = -1;
	/// Blends levels within a budget, so that the force does not jump where the level changes. At most two levels share the answer,
	/// with shares that follow the number of pairs; both are within the budget. All traversals together find less than four times the
	/// budget. Not with `sortPairs`.
	bool blend = false;
	/// Share of `otherLevel` in the answer, above 0 and up to 1; `level` has the rest. Use it to fade from one level to the other. It
	/// costs a query of both. Only with Model::Law; not with a budget, `sortPairs`, `listMeetingBounds` or an analytic field.
	double otherShare = 0;
	int otherLevel = 0;
	bool stiffness = true;   ///< fills stiffnessA and stiffnessB
	DampingWeights damping;  ///< weights with which `OverlapIntegrals::damping` is filled; not with Model::Inner
	bool patches = true;     ///< groups the pairs into patches; otherwise there is one patch
	/// Lists the pairs of balls in a reproducible order, for callers that read them (`OverlapResult::pairs`). The leaves answer, even where
	/// both bodies have a surface; for that, see `OverlapResult::facesA`.
	bool sortPairs = false;
	/// Also lists pairs of leaves whose bounding balls meet although they share no volume (lens 0). Gives one patch; not within a budget.
	bool listMeetingBounds = false;
	/// Suppresses the answer while the packed spheres of the two bodies are apart. Leaves reach beyond the surface by up to a gap, so
	/// bodies that only touch already press a little. This option removes that force, but also contact shallower than the gaps. It
	/// scales the integrals and leaves the listed pairs as they are. Where surfaces answer it does nothing, as they do not reach beyond.
	/// The error bar does not include what it removes. Cost: one query of the packed spheres (InnerOverlap.h).
	bool requireInnerOverlap = false;
	bool gate = false;  ///< former name of `requireInnerOverlap`, until 0.4; setting either one is enough
};

struct QueryCapacity
{
	/// Capacity of the list of pairs. If grouping into patches needs a longer list, a coarser level answers. Without levels, and with
	/// `sortPairs`, the sums stay exact, but there is one patch and the list is cut.
	int pairs = 200000;
	int patches = 8;          ///< largest number of patches in an answer
	int listEntries = 65536;  ///< capacity of each of two lists of open pairs of subtrees; with a small list fewer are opened at a time
};

/// One intersecting pair (`QueryOptions::sortPairs`): its indices into the `balls` of the result's trees, and its lens.
struct OverlapPair
{
	uint32_t ballA = 0, ballB = 0;
	float lens = 0;  ///< L [m^3]
	float area = 0;  ///< size of the gradient of L [m^2]; 0 when one contains the other
	Vec3 centroid;   ///< C [m], in A's mesh axes, relative to A's origin
	Vec3 normal;     ///< n; zero if both are concentric
};

/// Largest number of slots of a body's trees for Model::Law, levels included. The memory of a query grows with it.
std::size_t mostSlots(const InnerSphereTree& body);

/// Memory for trees that are larger than a workspace's arrays. Create it in a thread that may allocate, and take it in one that may
/// not. It needs 120 bytes per slot of B and 24 bytes per slot of A.
class QueryBuffers
{
public:
	/// Large enough for all queries with Model::Law of A and B, and of bodies with no more slots.
	QueryBuffers(const InnerSphereTree& A, const InnerSphereTree& B);
	~QueryBuffers();

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};

/// All memory of a query. Use one per thread, and reuse it. A query allocates only when a tree has more slots than all earlier trees and
/// no memory was reserved for it.
class QueryWorkspace
{
public:
	/// Uses the instruction set of `chosenInstructionSet`.
	explicit QueryWorkspace(const QueryCapacity& capacity = {});
	QueryWorkspace(const QueryCapacity& capacity, InstructionSet set);
	~QueryWorkspace();
	QueryWorkspace(QueryWorkspace&&) noexcept;
	QueryWorkspace& operator=(QueryWorkspace&&) noexcept;
	const QueryCapacity& capacity() const;
	/// Reserves the memory that QueryBuffers(A, B) would hold.
	void reserve(const InnerSphereTree& A, const InnerSphereTree& B);
	/// Makes the lists of pairs of leaves and of terms of closed forms resident: 35 MB with the default capacity. Without this, a query
	/// that finds more pairs than all earlier ones waits for the system to provide pages. Call it for a thread that must not wait, such as
	/// that of a haptic device.
	void makeResident();
	/// Swaps in each array of `room` that is larger than the workspace's own. Afterwards `room` is of no further use, and taking it
	/// again does nothing. Allocates and frees nothing.
	void take(QueryBuffers& room) noexcept;

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};

struct OverlapResult
{
	QueryStatus status = QueryStatus::Ok;
	OverlapIntegrals total;
	const OverlapIntegrals* patches = nullptr;  ///< patches in the workspace, valid until its next use; they sum to `total`
	int patchCount = 0;
	bool pairListComplete = true;        ///< false: there were more pairs than the capacity, so there is one patch and the list is cut
	const OverlapPair* pairs = nullptr;  ///< list in the workspace; filled only with `QueryOptions::sortPairs`
	int pairCount = 0;
	/// Faces of A inside B, and of B inside A, where surfaces answered (ContactFaces.h): in the workspace, valid until its next use, in A's
	/// axes and relative to A's origin. ContactPoints.h makes forces of them.
	const ContactFace *facesA = nullptr, *facesB = nullptr;
	size_t faceCountA = 0, faceCountB = 0;
	/// Where a body is flat where the other meets it, as a floor is, its depth is exact, and has this share of the weight of the other's in
	/// all of the sums. At most one of the two is 1.
	double leanOnA = 0, leanOnB = 0;
	const BallTree *ballsA = nullptr, *ballsB = nullptr;  ///< trees to which the indices of the pairs refer
	int level = 0;                                        ///< level that answered; the error bar (PressureField.h) grows with it
	double levelShare = 1;  ///< share of `level` in the answer; `otherLevel` has the rest (`QueryOptions::blend`, `otherShare`)
	int otherLevel = 0;
	bool coarsened = false;  ///< whether the level is coarser than requested, to stay within `maxPairs` or the capacity
	int64_t nodeVisits = 0, blockPairs = 0, ballTests = 0;  ///< work done, independent of the machine
};

class VerletList;

/// Overlap of two bodies. X_AB: pose of B's mesh frame in A's mesh frame. `memory`: Verlet list of these two bodies (VerletList.h), or
/// null for none; used for leaves only. Cost: O(pairs) or O(faces), no allocation.
OverlapResult queryOverlap(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const QueryOptions& options = {}, VerletList* memory = nullptr);

/// Overlap of A with a body in closed form. X_AF: pose of the field's frame in A's mesh frame.
/// B's pressure field is that of the exact body: `normalB` = Int n_B dV uses the normals of the nearest surface points, and `depthB`
/// its depth. All integrals of A are defined as with a tree.
/// A half-space or a box meets a tree with a surface by surfaces (PlanarBody.h), as two trees do: a pair is a face, and contact begins
/// where the bodies touch. Boxes thinner than 1e-4 of A are left to the leaves. Cost: O(faces). No allocation.
/// Otherwise A's leaves answer. A pair is a leaf that reaches into the field, patches are told apart by the field's normals, and
/// `stiffnessB` includes the curvature of the surface. Leaves larger than the field's subdivision size are divided (FieldClipper.h). Cost:
/// O(leaves in reach); only the first query of its kind allocates.
OverlapResult queryField(
	const InnerSphereTree& A, const AnalyticField& field, const Pose& X_AF, QueryWorkspace& workspace, const QueryOptions& options = {});

/// Overlap of A with the half-space { x : normal . x <= offset } of A's mesh frame. `normal` has unit length and points out of the
/// solid. `normalB` = volume * normal. With leaves, the caps of the ellipsoids are exact, and there is one patch.
OverlapResult queryHalfSpace(
	const InnerSphereTree& A, const Vec3& normal, double offset, QueryWorkspace& workspace, const QueryOptions& options = {});

/// Slow reference with simple code, for tests and benchmarks: tests all pairs in double and gives one patch.
OverlapResult queryOverlapBruteForce(
	const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, Model model = Model::Law, const DampingWeights& damping = {});
}  // namespace ist
