// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Contact/btISTContactStore.h"

class btISTContext;

/// Finds pairs that come deep into each other within a step because other contacts deflect one of them. Their free motion does not foretell
/// it. Not installed.
class btISTDeflectedPairs : public btISTMotionProbe
{
public:
	explicit btISTDeflectedPairs(btISTContext& context) : m_context(context) {}
	bool findDeeper(btISTContact& contact, const ist::Twist* motionA, const ist::Twist* motionB, double step) override;
	double timeUntilDeep(const btISTContact& contact, const ist::Twist* motionA, const ist::Twist* motionB, double step) override;

private:
	struct Deflected;
	struct Query;
	bool look(const btISTContact& contact, const Deflected& a, const Deflected& b, double mostOfKnown, double step);
	void forgetLook();

	btISTContext& m_context;
};
