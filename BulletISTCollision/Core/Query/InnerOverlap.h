// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/SmoothStep.h"
#include "BulletISTCollision/Core/Query/QueryMemory.h"

#include <algorithm>

namespace ist
{
/// Packed spheres lie inside their bodies. Where they share this part of what the leaves share, the bodies overlap beyond doubt.
constexpr double kInnerShare = 0.02;

/// What the gate lets pass, 0 to 1 with a continuous slope: `sure` is the volume that the packed spheres share, `volume` that of the
/// leaves.
inline double innerOverlapShare(double sure, double volume)
{
	const double t = volume > 0 ? std::min(1.0, sure / (kInnerShare * volume)) : 0;
	return smoothStep(t);
}

/// `answer(options)` behind the gate that `QueryOptions::requireInnerOverlap` asks for.
template <class Answer> OverlapResult answerWithInnerOverlap(const QueryOptions& options, QueryWorkspace& workspace, Answer answer)
{
	if (!options.requireInnerOverlap && !options.gate) return answer(options);
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
