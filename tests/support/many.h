/* How often a test repeats itself. */
#ifndef TEST_MANY_H
#define TEST_MANY_H

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TEST_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define TEST_SANITIZED 1
#endif
#endif
#ifndef TEST_SANITIZED
#define TEST_SANITIZED 0
#endif

/* Is it the one of threads, who looks for races? */
#if defined(__SANITIZE_THREAD__)
#define TEST_RACES 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define TEST_RACES 1
#endif
#endif
#ifndef TEST_RACES
#define TEST_RACES 0
#endif

/* Is it the one of memory, who looks for what was never written? Lanes behind the last of a row hold anything, and are computed
 * with, so that it has much to say of rendering. */
#if defined(__has_feature)
#if __has_feature(memory_sanitizer)
#define TEST_UNWRITTEN 1
#endif
#endif
#ifndef TEST_UNWRITTEN
#define TEST_UNWRITTEN 0
#endif

/* n; under a sanitizer, which is ten times slower and looks at accesses, not at numbers, a tenth of it. */
#define TEST_MANY(n) (TEST_SANITIZED ? (n) / 10 : (n))

#endif
