// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <vector>

namespace scenes
{
/// Number of rows of the Williams square of n conditions: n if n is even, 2 n if it is odd.
int williamsRows(int conditions);

/// Order of the conditions, from 0, in a block of a participant; both count from 0. It is a row of the Williams square, in which every
/// condition stands equally often at each place and follows every other one equally often. The row is (participant + block) modulo
/// williamsRows(), so the balance holds in each block, over any williamsRows() consecutive participants. The seed decides by which
/// condition each number of the square is replaced.
/// Source: E. J. Williams, Experimental designs balanced for the estimation of residual effects of treatments, 1949.
std::vector<int> studyOrder(int conditions, int participant, int block, std::uint64_t seed);
}  // namespace scenes
