-- A database of schema 0011, as its program left it (sqlite3 .dump). Do not change.
PRAGMA application_id = 1751339846;
BEGIN TRANSACTION;
CREATE TABLE batch (
	grid TEXT NOT NULL, 
	n INTEGER NOT NULL, 
	target TEXT NOT NULL, 
	keep TEXT NOT NULL, 
	scene TEXT NOT NULL, 
	prefix TEXT NOT NULL, 
	stage TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	passed INTEGER NOT NULL, 
	n_fixed INTEGER NOT NULL, 
	seconds REAL NOT NULL, 
	run_id INTEGER NOT NULL, 
	CONSTRAINT pk_batch PRIMARY KEY (grid, n, target, keep, scene, prefix, stage), 
	CONSTRAINT fk_batch_run FOREIGN KEY(run_id) REFERENCES run (id)
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "batch" VALUES('hex',12,'','all','','p','circuits',1,3,30,0.5,1);
INSERT INTO "batch" VALUES('hex',12,'','all','','p','foldings',1,2,20,0.25,1);
INSERT INTO "batch" VALUES('hex',12,'','all','','p','mobility',2,1,10,0.0625,1);
INSERT INTO "batch" VALUES('hex',12,'','all','','p','twist',1,1,10,0.125,1);
INSERT INTO "batch" VALUES('hex',12,'','all','default','p#0/1','deployment',40102,1,1,0.5,1);
INSERT INTO "batch" VALUES('hex',12,'','all','default','p#0/1','motion',102,1,1,0.5,1);
INSERT INTO "batch" VALUES('hex',12,'','all','solar','p#0/1','deployment',40102,0,0,0.5,2);
INSERT INTO "batch" VALUES('hex',12,'','all','solar','p#0/1','motion',102,1,1,0.5,2);
CREATE TABLE deployment (
	design_id INTEGER NOT NULL, 
	crease INTEGER NOT NULL, 
	base TEXT NOT NULL, 
	scene TEXT NOT NULL, 
	scene_values TEXT NOT NULL, 
	formulation TEXT NOT NULL, 
	status TEXT NOT NULL, 
	reason TEXT NOT NULL, 
	clearance REAL, 
	first_contact REAL, 
	deploy_time REAL, 
	energy_error REAL, 
	closure_error REAL, needed_margin REAL, least_gap REAL, as_crease INTEGER, 
	CONSTRAINT pk_deployment PRIMARY KEY (design_id, crease, base, scene), 
	CONSTRAINT ck_deployment_status CHECK (status IN ('deploys', 'undecided', 'collides', 'locked')), 
	CONSTRAINT fk_deployment_folding FOREIGN KEY(design_id, crease) REFERENCES folding (design_id, crease) ON DELETE CASCADE
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "deployment" VALUES(3,3,'default','default','design = "hex:023757:3"
formulation = "constrained"
panel_mm = "50x50x6"
flat_pairs = "rigid"
merge = false
','constrained','collides','so it was',NULL,0.25,NULL,1.0e-07,2.00000000000000033306e-06,NULL,NULL,NULL);
INSERT INTO "deployment" VALUES(3,3,'default','hinged','design = "hex:023757:3"
name = "hinged"
formulation = "constrained"
panel_mm = "50x50x6"
flat_pairs = "hinged"
merge = false
','constrained','deploys','so it was',1.5,NULL,0.5,1.0e-07,2.00000000000000033306e-06,0.01,-0.005,NULL);
INSERT INTO "deployment" VALUES(3,3,'solar','solar','design = "hex:023757:3"
name = "solar"
formulation = "constrained"
panel_mm = "1000x1000x20"
flat_pairs = "rigid"
merge = false
','constrained','collides','so it was',NULL,0.125,NULL,1.0e-07,2.00000000000000033306e-06,NULL,NULL,NULL);
CREATE TABLE design (
	id INTEGER NOT NULL, 
	grid TEXT NOT NULL, 
	n INTEGER NOT NULL, 
	circuit TEXT NOT NULL, 
	array TEXT NOT NULL, 
	array_symmetry INTEGER NOT NULL, 
	symmetry INTEGER NOT NULL, 
	n_fixed INTEGER NOT NULL, 
	n_foldings INTEGER, 
	n_untwisted INTEGER, 
	min_twist INTEGER, 
	best_crease INTEGER, 
	status TEXT, 
	CONSTRAINT pk_design PRIMARY KEY (id), 
	CONSTRAINT ck_design_status CHECK (status IN ('deploys', 'undecided', 'collides', 'locked', 'twisted', 'no_folding')), 
	CONSTRAINT ck_design_min_twist CHECK (min_twist >= 0), 
	CONSTRAINT ck_design_foldings CHECK (n_foldings >= 0 AND n_untwisted >= 0 AND n_untwisted <= n_foldings), 
	CONSTRAINT ck_design_symmetry CHECK (symmetry > 0 AND array_symmetry >= symmetry), 
	CONSTRAINT uq_design_circuit UNIQUE (circuit)
)
 STRICT

;
INSERT INTO "design" VALUES(1,'hex',12,'hex:007919','hex:array0',12,1,12,0,0,NULL,NULL,NULL);
INSERT INTO "design" VALUES(2,'hex',12,'hex:015838','hex:array0',12,2,6,2,0,1,NULL,NULL);
INSERT INTO "design" VALUES(3,'hex',12,'hex:023757','hex:array1',12,6,2,2,1,0,3,NULL);
CREATE TABLE evaluation (
	subject TEXT NOT NULL, 
	setting TEXT NOT NULL, 
	springs TEXT NOT NULL, 
	outcome TEXT NOT NULL, 
	clear INTEGER, 
	end_time REAL NOT NULL, 
	collision_time REAL, 
	first_panel INTEGER, 
	second_panel INTEGER, 
	gap REAL, 
	speed REAL, 
	remaining REAL, 
	end_remaining REAL, 
	widest REAL, 
	drift REAL, 
	opening REAL, 
	steps INTEGER NOT NULL, 
	evaluations INTEGER NOT NULL, 
	looks INTEGER NOT NULL, 
	CONSTRAINT pk_evaluation PRIMARY KEY (subject, setting, springs), 
	CONSTRAINT ck_evaluation_clear CHECK (clear IN (0, 1)), 
	CONSTRAINT ck_evaluation_outcome CHECK (outcome IN ('flat', 'moving', 'at rest', 'jammed', 'diverged', 'out of steps'))
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "evaluation" VALUES('thesis-4x4','{"seconds": 1.0}','0.1 0.2','flat',1,0.5,NULL,NULL,NULL,0.002,0.0,0.25,0.125,0.01,1.0e-06,NULL,100,1000,500);
CREATE TABLE folding (
	design_id INTEGER NOT NULL, 
	crease INTEGER NOT NULL, 
	opposite INTEGER NOT NULL, 
	twist INTEGER, 
	kutzbach INTEGER, 
	dof INTEGER, 
	dof_folded INTEGER, 
	dof_flat INTEGER, 
	merged_panels INTEGER, 
	kutzbach_merged INTEGER, 
	dof_merged INTEGER, 
	status TEXT, 
	CONSTRAINT pk_folding PRIMARY KEY (design_id, crease), 
	CONSTRAINT ck_folding_status CHECK (status IN ('deploys', 'undecided', 'collides', 'locked', 'twisted')), 
	CONSTRAINT ck_folding_crease CHECK (crease >= 0 AND opposite > crease), 
	CONSTRAINT ck_folding_twist CHECK (twist >= 0), 
	CONSTRAINT fk_folding_design FOREIGN KEY(design_id) REFERENCES design (id) ON DELETE CASCADE
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "folding" VALUES(2,1,7,1,6,6,7,6,0,NULL,NULL,NULL);
INSERT INTO "folding" VALUES(2,4,10,2,6,6,7,6,0,NULL,NULL,NULL);
INSERT INTO "folding" VALUES(3,0,6,1,6,6,7,6,0,NULL,NULL,NULL);
INSERT INTO "folding" VALUES(3,3,9,0,6,6,7,6,0,NULL,NULL,NULL);
CREATE TABLE hcsearch_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT hcsearch_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "hcsearch_version" VALUES('0011');
CREATE TABLE motion (
	design_id INTEGER NOT NULL, 
	crease INTEGER NOT NULL, 
	scene TEXT NOT NULL, 
	flat_pairs TEXT, 
	needed_margin REAL, 
	least_gap REAL, 
	slack REAL, 
	states INTEGER NOT NULL, 
	reason TEXT NOT NULL, 
	path BLOB, as_crease INTEGER, efforts INTEGER, lock_pairs TEXT, lock_end TEXT, lock_cubes INTEGER, lock_faces INTEGER, critical_margin REAL, unmet_margin REAL, lock_margin REAL, 
	CONSTRAINT pk_motion PRIMARY KEY (design_id, crease, scene), 
	CONSTRAINT ck_motion_flat_pairs CHECK (flat_pairs IN ('rigid', 'hinged', 'merged')), 
	CONSTRAINT fk_motion_scene FOREIGN KEY(scene) REFERENCES scene (name) ON DELETE CASCADE, 
	CONSTRAINT fk_motion_folding FOREIGN KEY(design_id, crease) REFERENCES folding (design_id, crease) ON DELETE CASCADE
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "motion" VALUES(3,3,'default','rigid',0.01,-0.005,1.0e-05,2,'a reason for deploys',X'789C93D07509F9ADC8E9C000060FEC19D0000054170362',NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL);
INSERT INTO "motion" VALUES(3,3,'locks',NULL,NULL,NULL,NULL,0,'locked by collision',NULL,NULL,3,'hinged','packed',106,1077,NULL,2.5,0.1);
INSERT INTO "motion" VALUES(3,3,'solar','rigid',0.01,-0.005,1.0e-05,2,'a reason for movable',X'789C93D07509F9ADC8E9C000060FEC19D0000054170362',NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL);
CREATE TABLE outcome (
	design_id INTEGER NOT NULL, 
	scene TEXT NOT NULL, 
	best_crease INTEGER NOT NULL, 
	status TEXT NOT NULL, 
	CONSTRAINT pk_outcome PRIMARY KEY (design_id, scene), 
	CONSTRAINT ck_outcome_status CHECK (status IN ('deploys', 'movable', 'undecided', 'locked')), 
	CONSTRAINT fk_outcome_scene FOREIGN KEY(scene) REFERENCES scene (name) ON DELETE CASCADE, 
	CONSTRAINT fk_outcome_folding FOREIGN KEY(design_id, best_crease) REFERENCES folding (design_id, crease) ON DELETE CASCADE
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "outcome" VALUES(3,'default',3,'deploys');
INSERT INTO "outcome" VALUES(3,'locks',3,'locked');
INSERT INTO "outcome" VALUES(3,'solar',3,'movable');
CREATE TABLE run (
	id INTEGER NOT NULL, 
	started TEXT NOT NULL, 
	finished TEXT, 
	grid TEXT NOT NULL, 
	n INTEGER NOT NULL, 
	target TEXT NOT NULL, 
	keep TEXT NOT NULL, 
	until TEXT NOT NULL, 
	panel TEXT, 
	arguments TEXT NOT NULL, 
	versions TEXT NOT NULL, 
	fixed_circuits INTEGER, 
	circuits INTEGER, 
	arrays INTEGER, 
	two_stack INTEGER, 
	untwisted INTEGER, 
	deploys INTEGER, 
	stage_times TEXT, 
	batches_done INTEGER, 
	batches_reused INTEGER, movable INTEGER, 
	CONSTRAINT pk_run PRIMARY KEY (id)
)
 STRICT

;
INSERT INTO "run" VALUES(1,'2026-11-22T21:28:29+00:00',NULL,'hex',12,'','all','deployment','50x50x6','{"grid": "hex", "keep": "all", "n": 12, "scene": "default", "until": "deployment"}','{"hcsearch": "0.1.0"}',NULL,NULL,NULL,NULL,NULL,1,NULL,NULL,NULL,1);
INSERT INTO "run" VALUES(2,'2026-11-22T21:28:29+00:00',NULL,'hex',12,'','all','deployment','1000x1000x20','{"grid": "hex", "keep": "all", "n": 12, "scene": "solar", "until": "deployment"}','{"hcsearch": "0.1.0"}',NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,1);
INSERT INTO "run" VALUES(3,'2026-11-25T21:51:58+00:00',NULL,'hex',12,'','all','motion',NULL,'{}','{}',NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL);
CREATE TABLE scene (
	name TEXT NOT NULL, 
	scene_values TEXT NOT NULL, 
	CONSTRAINT pk_scene PRIMARY KEY (name)
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "scene" VALUES('default','');
INSERT INTO "scene" VALUES('locks','name = "locks"
');
INSERT INTO "scene" VALUES('solar','name = "solar"
panel_mm = "1000x1000x20"
');
CREATE TABLE score (
	design_id INTEGER NOT NULL, 
	scene TEXT NOT NULL, 
	score REAL NOT NULL, 
	CONSTRAINT pk_score PRIMARY KEY (design_id, scene), 
	CONSTRAINT fk_score_design FOREIGN KEY(design_id) REFERENCES design (id) ON DELETE CASCADE
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "score" VALUES(3,'default',0.5);
INSERT INTO "score" VALUES(3,'solar',0.25);
CREATE TABLE unit (
	id INTEGER NOT NULL, 
	grid TEXT NOT NULL, 
	n INTEGER NOT NULL, 
	circuit TEXT NOT NULL, 
	crease INTEGER NOT NULL, 
	alpha REAL, 
	shape TEXT NOT NULL, 
	merged INTEGER NOT NULL, 
	element_dof INTEGER, 
	copies INTEGER NOT NULL, 
	placements TEXT NOT NULL, 
	panels INTEGER NOT NULL, 
	hinges INTEGER NOT NULL, 
	directions INTEGER NOT NULL, 
	loops INTEGER NOT NULL, 
	kutzbach INTEGER NOT NULL, 
	dof INTEGER NOT NULL, 
	dof_folded INTEGER, 
	dof_flat INTEGER, 
	rank_gap REAL NOT NULL, 
	deployment_ratio REAL NOT NULL, 
	ways INTEGER NOT NULL, 
	path TEXT NOT NULL, 
	closure_error REAL, 
	contact INTEGER, 
	known TEXT NOT NULL, 
	"key" TEXT NOT NULL, 
	CONSTRAINT pk_unit PRIMARY KEY (id), 
	CONSTRAINT ck_unit_copies CHECK (copies > 1 AND panels > 0 AND hinges > 0), 
	CONSTRAINT ck_unit_flags CHECK (merged IN (0, 1) AND contact IN (0, 1)), 
	CONSTRAINT ck_unit_alpha CHECK (alpha > 0 AND alpha < 90), 
	CONSTRAINT ck_unit_path CHECK (path IN ('flat', 'stopped', 'stepwise', 'none', 'locked')), 
	CONSTRAINT uq_unit_key UNIQUE ("key")
)
 STRICT

;
INSERT INTO "unit" VALUES(1,'triangle',10,'triangle:0123434501',1,NULL,'',0,2,4,'[]',21,24,3,4,0,1,4,4,1000000000.0,7.0,1,'flat',1.0e-14,0,'unit-i','triangle:0123434501 1 None  0 []');
CREATE TABLE verdict (
	design_id INTEGER NOT NULL, 
	crease INTEGER NOT NULL, 
	scene TEXT NOT NULL, 
	status TEXT NOT NULL, 
	min_clearance REAL, 
	deploy_time REAL, needed_margin REAL, least_gap REAL, 
	CONSTRAINT pk_verdict PRIMARY KEY (design_id, crease, scene), 
	CONSTRAINT ck_verdict_status CHECK (status IN ('deploys', 'movable', 'undecided', 'locked')), 
	CONSTRAINT fk_verdict_scene FOREIGN KEY(scene) REFERENCES scene (name) ON DELETE CASCADE, 
	CONSTRAINT fk_verdict_folding FOREIGN KEY(design_id, crease) REFERENCES folding (design_id, crease) ON DELETE CASCADE
)
 WITHOUT ROWID,
 STRICT

;
INSERT INTO "verdict" VALUES(3,3,'default','deploys',1.5,0.5,0.01,-0.005);
INSERT INTO "verdict" VALUES(3,3,'locks','locked',NULL,NULL,NULL,NULL);
INSERT INTO "verdict" VALUES(3,3,'solar','movable',NULL,NULL,0.01,-0.005);
CREATE INDEX ix_design_grid_n ON design (grid, n);
CREATE INDEX ix_unit_grid_n ON unit (grid, n);
CREATE VIEW designs AS SELECT
    d."id" AS "id",
    d."grid" AS "grid",
    d."n" AS "n",
    d."array" AS "array",
    d."circuit" AS "circuit",
    d."array_symmetry" AS "array_symmetry",
    d."symmetry" AS "symmetry",
    d.array_symmetry / d.symmetry AS "orbit_size",
    d."n_fixed" AS "n_fixed",
    d."n_foldings" AS "n_foldings",
    CASE WHEN d.n_foldings > 0 THEN 1 WHEN d.n_foldings = 0 THEN 0 END AS "two_stack",
    d."n_untwisted" AS "n_untwisted",
    CASE WHEN d.n_untwisted > 0 THEN 1 WHEN d.n_untwisted = 0 THEN 0 END AS "untwisted",
    d."min_twist" AS "min_twist",
    f."kutzbach" AS "kutzbach",
    f."dof" AS "dof",
    f."merged_panels" AS "merged_panels",
    f."kutzbach_merged" AS "kutzbach_merged",
    f."dof_merged" AS "dof_merged",
    CASE
        WHEN d.n_foldings = 0 OR (d.n_foldings > 0 AND d.n_untwisted = 0) THEN 0
        WHEN coalesce(o.status, d.status) IN ('no_folding', 'twisted', 'locked') THEN 0
        WHEN o.status IN ('deploys', 'movable') THEN 1
    END AS "deployable",
    m."flat_pairs" AS "flat_pairs",
    CASE
        WHEN CASE WHEN d.n_foldings > 0 AND d.n_untwisted = 0 THEN 1 END > 0 THEN 'twist'
        WHEN o.status = 'deploys' THEN 'deployment'
        WHEN o.status = 'movable' THEN 'path_proved'
        WHEN coalesce(o.status, d.status) = 'locked' AND m.lock_pairs IS NOT NULL THEN 'kept_apart'
        WHEN coalesce(o.status, d.status) = 'locked' THEN 'locked_at_end'
        WHEN m.states > 0 THEN 'path_met'
        WHEN m.states = 0 THEN 'no_path_met'
    END AS "known",
    m."critical_margin" AS "critical_margin",
    m."unmet_margin" AS "unmet_margin",
    v."needed_margin" AS "needed_margin",
    v."least_gap" AS "least_gap",
    v."min_clearance" AS "min_clearance",
    v."deploy_time" AS "deploy_time",
    CASE
        WHEN d.n_foldings = 0 THEN 'no_folding'
        WHEN d.n_foldings > 0 AND d.n_untwisted = 0 THEN 'twisted'
        ELSE coalesce(o.status, d.status)
    END AS "status",
    s.score AS "score",
    CASE WHEN d.n_untwisted > 0 THEN d.n / 2 END AS "deployment_ratio",
    CASE WHEN d.n_untwisted > 0 THEN d.n - 2 END AS "hinges"
FROM design AS d
LEFT JOIN outcome AS o ON o.design_id = d.id AND o.scene = 'default'
LEFT JOIN folding AS f ON f.design_id = d.id AND f.crease = coalesce((SELECT b.best_crease FROM outcome AS b WHERE b.design_id = d.id AND b.scene = 'default'), d.best_crease)
LEFT JOIN verdict AS v ON v.design_id = d.id AND v.scene = 'default' AND v.crease = (SELECT b.best_crease FROM outcome AS b WHERE b.design_id = d.id AND b.scene = 'default')
LEFT JOIN motion AS m ON m.design_id = d.id AND m.scene = 'default' AND m.crease = (SELECT b.best_crease FROM outcome AS b WHERE b.design_id = d.id AND b.scene = 'default')
LEFT JOIN score AS s ON s.design_id = d.id AND s.scene = 'default';
CREATE VIEW foldings AS SELECT
    f."design_id" AS "design_id",
    f."crease" AS "crease",
    f."opposite" AS "opposite",
    f."twist" AS "twist",
    CASE WHEN f.twist = 0 THEN 1 WHEN f.twist > 0 THEN 0 END AS "untwisted",
    f."kutzbach" AS "kutzbach",
    f."dof" AS "dof",
    f."dof_folded" AS "dof_folded",
    f."dof_flat" AS "dof_flat",
    f."merged_panels" AS "merged_panels",
    f."kutzbach_merged" AS "kutzbach_merged",
    f."dof_merged" AS "dof_merged",
    CASE WHEN f.twist > 0 THEN 'twisted' ELSE coalesce(v.status, f.status) END AS "status",
    CASE
        WHEN f.twist > 0 OR coalesce(v.status, f.status) IN ('twisted', 'locked') THEN 0
        WHEN v.status IN ('deploys', 'movable') THEN 1
    END AS "deployable",
    m.flat_pairs AS "flat_pairs",
    CASE
        WHEN f.twist > 0 THEN 'twist'
        WHEN v.status = 'deploys' THEN 'deployment'
        WHEN v.status = 'movable' THEN 'path_proved'
        WHEN coalesce(v.status, f.status) = 'locked' AND m.lock_pairs IS NOT NULL THEN 'kept_apart'
        WHEN coalesce(v.status, f.status) = 'locked' THEN 'locked_at_end'
        WHEN m.states > 0 THEN 'path_met'
        WHEN m.states = 0 THEN 'no_path_met'
    END AS "known",
    m.critical_margin AS "critical_margin",
    m.unmet_margin AS "unmet_margin",
    v.needed_margin AS "needed_margin",
    v.least_gap AS "least_gap",
    v.min_clearance AS "min_clearance",
    v.deploy_time AS "deploy_time"
FROM folding AS f
LEFT JOIN verdict AS v ON v.design_id = f.design_id AND v.crease = f.crease AND v.scene = 'default'
LEFT JOIN motion AS m ON m.design_id = f.design_id AND m.crease = f.crease AND m.scene = 'default';
CREATE VIEW motions AS SELECT
    m."design_id" AS "design_id",
    m."crease" AS "crease",
    m."scene" AS "scene",
    m."flat_pairs" AS "flat_pairs",
    m."needed_margin" AS "needed_margin",
    m."least_gap" AS "least_gap",
    m."slack" AS "slack",
    m."states" AS "states",
    m."reason" AS "reason",
    m."as_crease" AS "as_crease",
    m."efforts" AS "efforts",
    m."lock_pairs" AS "lock_pairs",
    m."lock_end" AS "lock_end",
    m."lock_cubes" AS "lock_cubes",
    m."lock_faces" AS "lock_faces",
    m."critical_margin" AS "critical_margin",
    m."unmet_margin" AS "unmet_margin",
    m."lock_margin" AS "lock_margin"
FROM motion AS m;
CREATE VIEW deployments AS SELECT
    p."design_id" AS "design_id",
    p."crease" AS "crease",
    p."scene" AS "scene",
    p."base" AS "base",
    p."scene_values" AS "scene_values",
    p."formulation" AS "formulation",
    p."status" AS "status",
    p."reason" AS "reason",
    p."clearance" AS "clearance",
    p."first_contact" AS "first_contact",
    p."deploy_time" AS "deploy_time",
    p."energy_error" AS "energy_error",
    p."closure_error" AS "closure_error",
    p."needed_margin" AS "needed_margin",
    p."least_gap" AS "least_gap",
    p."as_crease" AS "as_crease"
FROM deployment AS p;
CREATE VIEW runs AS SELECT
    r."id" AS "id",
    r."started" AS "started",
    r."finished" AS "finished",
    r."grid" AS "grid",
    r."n" AS "n",
    r."target" AS "target",
    r."keep" AS "keep",
    r."until" AS "until",
    r."panel" AS "panel",
    r."arguments" AS "arguments",
    r."versions" AS "versions",
    r."fixed_circuits" AS "fixed_circuits",
    r."circuits" AS "circuits",
    r."arrays" AS "arrays",
    r."two_stack" AS "two_stack",
    r."untwisted" AS "untwisted",
    r."movable" AS "movable",
    r."deploys" AS "deploys",
    r."stage_times" AS "stage_times",
    r."batches_done" AS "batches_done",
    r."batches_reused" AS "batches_reused"
FROM run AS r;
CREATE VIEW units AS SELECT
    u."id" AS "id",
    u."grid" AS "grid",
    u."n" AS "n",
    u."circuit" AS "circuit",
    u."crease" AS "crease",
    u."alpha" AS "alpha",
    u."shape" AS "shape",
    u."merged" AS "merged",
    u."element_dof" AS "element_dof",
    u."copies" AS "copies",
    u."placements" AS "placements",
    u."panels" AS "panels",
    u."hinges" AS "hinges",
    u."directions" AS "directions",
    u."loops" AS "loops",
    u."kutzbach" AS "kutzbach",
    u."dof" AS "dof",
    u."dof_folded" AS "dof_folded",
    u."dof_flat" AS "dof_flat",
    u."rank_gap" AS "rank_gap",
    u."deployment_ratio" AS "deployment_ratio",
    u."ways" AS "ways",
    u."path" AS "path",
    u."closure_error" AS "closure_error",
    u."contact" AS "contact",
    u."known" AS "known"
FROM unit AS u;
CREATE VIEW evaluations AS SELECT
    e."subject" AS "subject",
    e."setting" AS "setting",
    e."springs" AS "springs",
    e."outcome" AS "outcome",
    e."clear" AS "clear",
    e."end_time" AS "end_time",
    e."collision_time" AS "collision_time",
    e."first_panel" AS "first_panel",
    e."second_panel" AS "second_panel",
    e."gap" * 1000.0 AS "clearance",
    e."speed" AS "speed",
    e."remaining" AS "remaining",
    e."end_remaining" AS "end_remaining",
    e."widest" AS "widest",
    e."drift" AS "drift",
    e."opening" AS "opening",
    e."steps" AS "steps",
    e."evaluations" AS "evaluations",
    e."looks" AS "looks"
FROM evaluation AS e;
COMMIT;
