-- A catalog as the first build wrote it (commit fec2531, sqlite3 .dump): it must open for ever.
PRAGMA foreign_keys=OFF;
BEGIN TRANSACTION;
CREATE TABLE counter (
         name TEXT NOT NULL PRIMARY KEY,
         value BIGINT NOT NULL);
INSERT INTO counter VALUES('job',2);
CREATE TABLE mesh (
         set_name TEXT NOT NULL,
         name TEXT NOT NULL,
         raw TEXT NOT NULL,
         size_bytes BIGINT NOT NULL,
         labels TEXT NOT NULL,
         PRIMARY KEY (set_name, name));
INSERT INTO mesh VALUES('faces','a.ply','fc86562d2e57432533b95007f3372759bd18757ae0ff2ee99a4ae2a6653113db',5000000000,'{"person":"p \"1\"","věk":"33"}');
INSERT INTO mesh VALUES('faces','b.ply','8ff65ced0336db68d93159721dfc0348bfb28633757728379ee25341a76919fb',5000000000,'{"person":"p \"1\"","věk":"33"}');
CREATE TABLE ingested (
         raw TEXT NOT NULL,
         position_bits BIGINT NOT NULL,
         result TEXT NOT NULL,
         PRIMARY KEY (raw, position_bits));
INSERT INTO ingested VALUES('fc86562d2e57432533b95007f3372759bd18757ae0ff2ee99a4ae2a6653113db',18,'{"counters":{"align":{"index_builds":0,"lookups":0},"average":{"index_builds":0,"lookups":0},"compare":{"index_builds":0,"lookups":0},"pairs":0,"pose":{"index_builds":0,"lookups":0},"variation":{"index_builds":0,"lookups":0}},"ingested":[{"blob":"5bcb023723ce123ebbdc736909d7975d3b9600fe469587b0697ef808ccc3f61b","centroid":[0.3333333333333333,-2e-300,4.0],"faces":10000,"health":{"boundary_share":0.1,"components":0,"degenerate_faces":0,"diagonal":0.0,"duplicate_faces":0,"duplicate_vertices":0,"faces":0,"largest_component_share":0.0,"non_manifold_edges":0,"point_cloud":false,"rms_radius":0.0,"surface_area":0.0,"unreferenced_vertices":0,"vertices":5121,"warnings":["4 components; the largest has 97 % of faces"]},"index":0,"vertices":5120}],"output":"","rejections":[],"second_output":"","seconds":0.0}');
CREATE TABLE job (
         number BIGINT NOT NULL PRIMARY KEY,
         request_id TEXT NOT NULL,
         set_name TEXT NOT NULL,
         spec TEXT NOT NULL,
         state TEXT NOT NULL,
         error TEXT NOT NULL,
         version BIGINT NOT NULL,
         created_unix_ms BIGINT NOT NULL,
         started_unix_ms BIGINT NOT NULL,
         finished_unix_ms BIGINT NOT NULL,
         meshes BIGINT NOT NULL,
         rejected_meshes BIGINT NOT NULL,
         progress TEXT NOT NULL,
         counters TEXT NOT NULL,
         outputs TEXT NOT NULL);
INSERT INTO job VALUES(1,'request 1','faces','{"base":"b.ply","icp":{"max_iterations":200,"scale":"free","tolerance":1e-06},"method":"average","metric":"rms","neighbours":3,"pose":"principal-axes","position_bits":18,"rounds":7,"size_ratio_limit":5.0,"symmetrization":"mean"}','running','',5,1790000000000,1790000000001,0,2,0,'{"cost_done":0.5,"cost_total":2.0,"stage":"align 1","tasks_done":3,"tasks_total":10}','{"counters":{"align":{"index_builds":5,"lookups":123456789012},"average":{"index_builds":0,"lookups":0},"compare":{"index_builds":0,"lookups":0},"pairs":9,"pose":{"index_builds":0,"lookups":0},"variation":{"index_builds":0,"lookups":0}},"ingested":[],"output":"","rejections":[],"second_output":"","seconds":0.0}','{"alignments":[],"mean_shape":"","summary":"","tiles":[]}');
INSERT INTO job VALUES(2,'','faces','{"base":"b.ply","icp":{"max_iterations":200,"scale":"free","tolerance":1e-06},"method":"average","metric":"rms","neighbours":3,"pose":"principal-axes","position_bits":18,"rounds":7,"size_ratio_limit":5.0,"symmetrization":"mean"}','succeeded','',9,1790000000002,0,1790000000003,2,0,'{"cost_done":0.0,"cost_total":0.0,"stage":"","tasks_done":0,"tasks_total":0}','{"counters":{"align":{"index_builds":0,"lookups":0},"average":{"index_builds":0,"lookups":0},"compare":{"index_builds":0,"lookups":0},"pairs":0,"pose":{"index_builds":0,"lookups":0},"variation":{"index_builds":0,"lookups":0}},"ingested":[],"output":"","rejections":[],"second_output":"","seconds":0.0}','{"alignments":["47ccb97a79f5a2bff2713968c83bbbea9cd53d2edf6b0a47439910e111c95fe9"],"mean_shape":"82523faea1b0f2da676a0561d597000bb6918036c6e541dc1145966141864332","summary":"761b7ad8ad439b2855fcbb611331c646ef0870b0631247bba3f3025cb6df5a53","tiles":["8b668b8994aa845107399994593d0ca831520be5257f005351a0ec13e97a39be"]}');
CREATE TABLE job_mesh (
         job BIGINT NOT NULL REFERENCES job (number),
         idx BIGINT NOT NULL,
         name TEXT NOT NULL,
         raw TEXT NOT NULL,
         size_bytes BIGINT NOT NULL,
         labels TEXT NOT NULL,
         ingested TEXT NOT NULL,
         rejection TEXT NOT NULL,
         PRIMARY KEY (job, idx));
INSERT INTO job_mesh VALUES(1,0,'a.ply','fc86562d2e57432533b95007f3372759bd18757ae0ff2ee99a4ae2a6653113db',5000000000,'{"person":"p \"1\"","věk":"33"}','','');
INSERT INTO job_mesh VALUES(1,1,'b.ply','8ff65ced0336db68d93159721dfc0348bfb28633757728379ee25341a76919fb',5000000000,'{"person":"p \"1\"","věk":"33"}','','');
INSERT INTO job_mesh VALUES(2,0,'a.ply','fc86562d2e57432533b95007f3372759bd18757ae0ff2ee99a4ae2a6653113db',5000000000,'{"person":"p \"1\"","věk":"33"}','{"counters":{"align":{"index_builds":0,"lookups":0},"average":{"index_builds":0,"lookups":0},"compare":{"index_builds":0,"lookups":0},"pairs":0,"pose":{"index_builds":0,"lookups":0},"variation":{"index_builds":0,"lookups":0}},"ingested":[{"blob":"5bcb023723ce123ebbdc736909d7975d3b9600fe469587b0697ef808ccc3f61b","centroid":[0.3333333333333333,-2e-300,4.0],"faces":10000,"health":{"boundary_share":0.1,"components":0,"degenerate_faces":0,"diagonal":0.0,"duplicate_faces":0,"duplicate_vertices":0,"faces":0,"largest_component_share":0.0,"non_manifold_edges":0,"point_cloud":false,"rms_radius":0.0,"surface_area":0.0,"unreferenced_vertices":0,"vertices":5121,"warnings":["4 components; the largest has 97 % of faces"]},"index":0,"vertices":5120}],"output":"","rejections":[],"second_output":"","seconds":0.0}','');
INSERT INTO job_mesh VALUES(2,1,'b.ply','8ff65ced0336db68d93159721dfc0348bfb28633757728379ee25341a76919fb',5000000000,'{"person":"p \"1\"","věk":"33"}','','line 7: NaN');
CREATE TABLE task (
         job BIGINT NOT NULL REFERENCES job (number),
         number BIGINT NOT NULL,
         epoch BIGINT NOT NULL,
         failures BIGINT NOT NULL,
         losses BIGINT NOT NULL,
         worker TEXT NOT NULL,
         result TEXT NOT NULL,
         last_error TEXT NOT NULL,
         PRIMARY KEY (job, number));
INSERT INTO task VALUES(1,1,3000000000,1,2,'host-12-ab','{"counters":{"align":{"index_builds":0,"lookups":123456789012},"average":{"index_builds":0,"lookups":0},"compare":{"index_builds":0,"lookups":0},"pairs":0,"pose":{"index_builds":0,"lookups":0},"variation":{"index_builds":0,"lookups":0}},"ingested":[{"blob":"5bcb023723ce123ebbdc736909d7975d3b9600fe469587b0697ef808ccc3f61b","centroid":[0.3333333333333333,-2e-300,4.0],"faces":10000,"health":{"boundary_share":0.1,"components":0,"degenerate_faces":0,"diagonal":0.0,"duplicate_faces":0,"duplicate_vertices":0,"faces":0,"largest_component_share":0.0,"non_manifold_edges":0,"point_cloud":false,"rms_radius":0.0,"surface_area":0.0,"unreferenced_vertices":0,"vertices":5121,"warnings":["4 components; the largest has 97 % of faces"]},"index":0,"vertices":5120},{"blob":"a75b2808160584a7682a104129e34241e75a3e3fc6644518dc45bdec324e7981","centroid":[0.3333333333333333,-2e-300,4.0],"faces":10000,"health":{"boundary_share":0.1,"components":0,"degenerate_faces":0,"diagonal":0.0,"duplicate_faces":0,"duplicate_vertices":0,"faces":0,"largest_component_share":0.0,"non_manifold_edges":0,"point_cloud":false,"rms_radius":0.0,"surface_area":0.0,"unreferenced_vertices":0,"vertices":5121,"warnings":["4 components; the largest has 97 % of faces"]},"index":1,"vertices":5120}],"output":"e0ee8bb50685e05fa0f47ed04203ae953fdfd055f5bd2892ea186504254f8c3a","rejections":[{"index":2,"reason":"NaN"}],"second_output":"","seconds":0.1}',replace('mesh ''x'': no\nfaces','\n',char(10)));
INSERT INTO task VALUES(1,2,3000000000,1,2,'host-12-ab','',replace('mesh ''x'': no\nfaces','\n',char(10)));
CREATE UNIQUE INDEX job_by_request ON job (request_id) WHERE request_id <> '';
CREATE INDEX job_by_state ON job (state, number);
PRAGMA application_id = 1129269332;
PRAGMA user_version = 1;
COMMIT;
