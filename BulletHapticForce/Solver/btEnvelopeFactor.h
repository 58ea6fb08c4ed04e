// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/Solver/btKeyedLists.h"

#include <cstddef>
#include <cstdint>
#include <vector>

/// Cholesky factorisation A = L L^T of a symmetric positive definite matrix of 6 x 6 blocks, one row of blocks for each place. Row r is
/// stored from its first block that is not zero to its diagonal: this is the envelope, and elimination fills nothing outside it.
///
/// The clique of a place holds the place itself and all later places whose rows reach back to it. A back substitution needs no other place.
/// All blocks of the inverse between two members of a clique lie within the envelope, and `invert` finds them without any other block.
///
/// Cost: factorise and invert O(sum over the places of the square of the clique's size), one substitution O(blocks of the envelope). A
/// chain and a star have cliques of two. No allocation once `reserve` has seen the size.
class btEnvelopeFactor
{
public:
	static constexpr int kSide = 6, kBlock = 36;

	void reserve(int places);
	/// Begins a new envelope, which holds the diagonal only.
	void begin(int places);
	/// Two places whose block is not zero. Their order does not matter.
	void couple(int a, int b);
	/// Ends the envelope. From now on the values may be set any number of times.
	void layOut();
	/// Takes the envelope of another factor, without its values.
	void layOutAs(const btEnvelopeFactor& other);
	int places() const { return m_places; }
	/// Members of the clique of `place` without the place itself, in ascending order.
	const int* cliqueBegin(int place) const { return m_cliques.begin(place); }
	const int* cliqueEnd(int place) const { return m_cliques.end(place); }
	/// Number of values within the envelope, which one substitution reads.
	int64_t entries() const;
	/// Number of blocks within the envelope.
	int64_t blocks() const { return int64_t(m_size / kBlock); }

	/// Sets A = I.
	void setIdentity();
	/// Adds a row-major block to A. `row` >= `column`, and the two must be coupled or equal.
	void add(int row, int column, const double* block);
	/// Replaces A by L. False when A is not positive definite, or not finite.
	bool factorise();
	/// Computes the blocks of the inverse of A that lie within the envelope. Call it after `factorise`.
	void invert();
	/// Row-major block of the inverse, valid after `invert`. `row` >= `column`, and the two must be coupled or equal.
	const double* inverseBlock(int row, int column) const { return m_inverse.data() + blockOf(row, column); }

	/// Replaces x by L^-1 x.
	void substituteForward(double* x);
	/// Makes one step of the back substitution: the six numbers of `place` become those of L^-T x. All later members of its clique must
	/// have theirs already.
	void substituteBack(double* x, int place);
	void solve(double* x);

	/// Number of products of a block with a block or with a column since the object was made. It measures the work independent of a
	/// clock.
	uint64_t products() const { return m_products; }

private:
	// Rows of blocks are stored one after the other, each as six dense rows of numbers. Rows of the inverse are stored block by block.
	int width(int place) const { return kSide * (place - m_first[size_t(place)] + 1); }
	size_t rowOf(int place) const { return m_row[size_t(place)]; }
	size_t blockOf(int row, int column) const { return m_row[size_t(row)] + size_t(kBlock) * size_t(column - m_first[size_t(row)]); }
	const double* factorBlock(int row, int column) const { return m_factor.data() + rowOf(row) + kSide * (column - m_first[size_t(row)]); }

	int m_places = 0;
	std::vector<int> m_first;      // place of the first block of each row
	std::vector<size_t> m_row;     // index of the first number of each row
	btKeyedLists m_cliques;        // members of the clique of each place without the place itself
	std::vector<double> m_factor;  // the factor L, with the inverse of each diagonal entry
	std::vector<double> m_inverse;
	std::vector<double> m_quotients;  // L_mb L_bb^-1 for one column of blocks
	size_t m_size = 0;                // total number of values in the rows
	uint64_t m_products = 0;
};
