// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/btISTContactStore.h"
#include "BulletISTCollision/btISTRegistry.h"
#include "BulletISTCollision/btISTWatch.h"
#include "BulletISTCollision/btPrecisionGuard.h"

#include "BulletCollision/BroadphaseCollision/btBroadphaseProxy.h"
#include "BulletCollision/CollisionDispatch/btCollisionCreateFunc.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

class btISTContext;
class btISTInstallation;

/// One for each table: it finds out from the shapes for which entry it was called.
struct btISTCreateFunc : btCollisionAlgorithmCreateFunc
{
	btISTContext* context = nullptr;
	bool closest = false;
	btCollisionAlgorithmCreateFunc* previous[MAX_BROADPHASE_COLLISION_TYPES][MAX_BROADPHASE_COLLISION_TYPES] = {};

	btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* wrap0,
												   const btCollisionObjectWrapper* wrap1) override;
};

/// What algorithms need, for as long as one of them or a registration lives.
class btISTContext : public std::enable_shared_from_this<btISTContext>
{
public:
	btISTContext()
	{
		contacts.context = closest.context = this;
		closest.closest = true;
	}
	btISTCreateFunc& function(bool ofClosest) { return ofClosest ? closest : contacts; }

	btISTCreateFunc contacts, closest;
	bool active = true;
	btISTContactStore store;
	std::shared_ptr<btISTRegistry> registry;
	btISTWatch watch;
	std::shared_ptr<const btISTPairRule> rule = std::make_shared<btISTDefaultPairRule>();
	ist::QueryWorkspace workspace;
	btISTEconomy economy;
	std::weak_ptr<btISTInstallation> installation;

	const ist::QueryOptions& options() const { return m_options; }
	/// Accepted of all pairs but those of bodies that have one of their own; 0: the leaves answer.
	double forceError() const { return m_forceError; }
	/// Accepted of a pair. O(bodies that have one of their own).
	double forceErrorOf(const btCollisionObject* a, const btCollisionObject* b) const
	{
		double own = std::numeric_limits<double>::infinity();
		for (const auto& [body, share] : m_errorsOfBodies)
			if (body == a || body == b) own = std::min(own, share);
		return std::isfinite(own) ? own : m_forceError;
	}
	/// Without a share, as all others again.
	void setForceErrorOf(const btCollisionObject* body, std::optional<double> share)
	{
		const auto isIt = [body](const auto& entry) { return entry.first == body; };
		m_errorsOfBodies.erase(std::remove_if(m_errorsOfBodies.begin(), m_errorsOfBodies.end(), isIt), m_errorsOfBodies.end());
		if (share) m_errorsOfBodies.emplace_back(body, *share);
		++m_optionsVersion;
	}
	/// Another one after every change of how queries answer: no result of the former ones is kept.
	uint64_t optionsVersion() const { return m_optionsVersion; }
	void setQueries(const ist::QueryOptions& options, double forceError)
	{
		m_options = options;
		m_forceError = forceError;
		++m_optionsVersion;
	}

private:
	ist::QueryOptions m_options;
	double m_forceError = 0;
	std::vector<std::pair<const btCollisionObject*, double>> m_errorsOfBodies;
	uint64_t m_optionsVersion = 0;
};
