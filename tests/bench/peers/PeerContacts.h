// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Pose.h"
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <memory>
#include <string>
#include <vector>

namespace bench
{
/// Answer of a library for two bodies: the sum of depth times normal over its contacts. It points where A must move to leave B.
struct PeerAnswer
{
	ist::Vec3 push;
	int contacts = 0;
};

/// Two bodies as a user of a library would set them up, and that library's own query with every contact.
class Peer
{
public:
	virtual ~Peer() = default;
	virtual std::string name() const = 0;
	virtual PeerAnswer ask(const ist::Pose& X_AB) = 0;
};

/// The libraries that were found at build time. HACD decomposes coarse copies of the meshes.
std::vector<std::unique_ptr<Peer>> makePeers(const ist::Mesh& A, const ist::Mesh& B);
std::unique_ptr<Peer> makeFclPeer(const ist::Mesh& A, const ist::Mesh& B);
std::unique_ptr<Peer> makeOdePeer(const ist::Mesh& A, const ist::Mesh& B);
}  // namespace bench
