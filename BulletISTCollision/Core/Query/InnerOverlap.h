// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SmoothStep.h"
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"

#include <algorithm>

namespace ist
{
/// Share of the leaves' volume above which the volume of the packed spheres proves the overlap. Packed spheres lie inside their bodies.
constexpr double kInnerShare = 0.02;

/// Factor on the integrals with `requireInnerOverlap`, 0 to 1 with a continuous slope. `sure`: overlap volume of the packed
/// spheres; `volume`: overlap volume of the leaves.
inline double innerOverlapShare(double sure, double volume)
{
	const double t = volume > 0 ? std::min(1.0, sure / (kInnerShare * volume)) : 0;
	return smoothStep(t);
}

/// Whether the options ask for it, by its present or by its former name.
inline bool wantsInnerOverlap(const QueryOptions& options) { return options.requireInnerOverlap || options.gate; }

/// Returns `answer(options)`, scaled by innerOverlapShare() when `QueryOptions::requireInnerOverlap` is set.
template <class Answer> OverlapResult answerWithInnerOverlap(const QueryOptions& options, QueryWorkspace& workspace, Answer answer)
{
	if (!wantsInnerOverlap(options)) return answer(options);
	QueryOptions packed;
	packed.model = Model::Inner;
	packed.patches = packed.stiffness = false;
	const OverlapResult sure = answer(packed);
	if (sure.status != QueryStatus::Ok || !(sure.total.volume > 0)) return sure;
	OverlapResult result = answer(options);
	const double share = innerOverlapShare(sure.total.volume, result.total.volume);
	result.total.scale(share);
	for (int p = 0; p < result.patchCount; ++p) workspace.implementation().patches[p].scale(share);
	result.nodeVisits += sure.nodeVisits;
	result.blockPairs += sure.blockPairs;
	result.ballTests += sure.ballTests;
	return result;
}
}  // namespace ist
